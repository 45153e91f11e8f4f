use std::ops::Range;

use numerics::lanes::{buffer, by_lane, interleave, lane, lane_of};
use numerics::{LANES, Lane, Wide};
use refusal::Invalid;
use ship::engine::{
    Current, Disturbances, Diverged, Driven, Driving, Helm, Recording, Run, Streams, Wind, diverged_lanes,
    simulate_command, simulate_commanded, simulate_disturbed,
};
use ship::model::{Model, Source, Vessel};
use thiserror::Error;

/// The true vessel and its disturbances. Simulates up to [`LANES`] runs in lanes.
pub struct Sea<'a> {
    vessel: &'a Vessel,
    truth: Vec<Lane>,
    disturbances: Disturbances,
    wind: Option<Wind>,
}

/// Runs of one design that are simulated in lanes.
pub struct Group<'a> {
    /// Name of the design.
    pub design: &'a str,
    /// The random streams of the disturbances.
    pub streams: &'a Streams,
    /// Numbers of the runs, up to [`LANES`].
    pub runs: &'a [u32],
    /// Initial state of each: u, v \[m/s\], r \[rad/s\].
    pub initial: Vec<[f64; 3]>,
    /// Exogenous inputs of each, N × exogenous, row-major; N is the same for all.
    pub exogenous: Vec<&'a [f64]>,
    /// The commands of each, if they depend on the ship's motion. Then the above are those of an undisturbed ship.
    pub helms: Vec<Helm>,
}

/// What of simulated runs is wanted in addition to their measured states.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Wanted {
    /// Nothing.
    Measured,
    /// The true states.
    Truth,
    /// The true states, and what was commanded where maneuvers react.
    Commands,
}

/// States of a group's runs, (N+1) × 3, row-major.
pub struct States {
    /// The true ones; empty if not requested.
    pub truth: Vec<Lane>,
    /// With measurement noise.
    pub measured: Vec<Lane>,
    /// The exogenous inputs of the runs, N × exogenous; empty where all runs have the same ones.
    pub(super) exogenous: Vec<Lane>,
    /// What was commanded, N × inputs; empty where it is not wanted, or no maneuver reacts.
    pub(super) commands: Vec<Lane>,
}

/// A run as it would be recorded, with the true states.
#[derive(Clone, Debug, PartialEq)]
pub struct SimulatedRun {
    /// The recording.
    pub run: Run,
    /// True states, (N+1) × 3, row-major.
    pub states: Vec<f64>,
    /// What was commanded, N × inputs, row-major; empty where no maneuver reacts, or it is not wanted.
    pub commands: Vec<f64>,
}

impl States {
    /// True and measured states of one run, (N+1) × 3.
    pub fn of(&self, lane: usize) -> [Vec<f64>; 2] {
        [&self.truth, &self.measured].map(|states| lane_of(states, lane))
    }

    /// The exogenous inputs of one run, N × exogenous; `None` where all runs have the same ones.
    pub fn exogenous_of(&self, lane: usize) -> Option<Vec<f64>> {
        (!self.exogenous.is_empty()).then(|| lane_of(&self.exogenous, lane))
    }
}

impl<'a> Sea<'a> {
    /// The true parameters of `vessel` with these disturbances.
    ///
    /// # Errors
    /// A vessel without true parameters.
    pub fn new(vessel: &'a Vessel, disturbances: Disturbances, wind: Option<Wind>) -> Result<Self, Invalid> {
        let truth = vessel.parameters(Source::Value)?.into_iter().map(Lane::splat).collect();
        Ok(Self { vessel, truth, disturbances, wind })
    }

    /// The vessel.
    pub fn vessel(&self) -> &'a Vessel {
        self.vessel
    }

    /// Simulates a group. The disturbances of a run's first samples do not depend on its length.
    ///
    /// # Errors
    /// A vessel whose motion diverges, or disturbances that cause it.
    pub fn simulate(&self, group: &Group) -> Result<States, Refusal> {
        let [states] = self.simulate_groups([group], Wanted::Truth)?;
        Ok(states)
    }

    /// Simulates groups of runs of one length, with what is `wanted` of them.
    pub(super) fn simulate_groups<const G: usize>(
        &self,
        groups: [&Group; G],
        wanted: Wanted,
    ) -> Result<[States; G], Refusal> {
        let (states, beyond) = self.followed(groups, wanted);
        for (group, beyond) in groups.into_iter().zip(beyond) {
            if (0..group.runs.len()).any(|lane| beyond[lane] > 0.0) {
                let [States { truth, .. }] = self.followed([group], Wanted::Truth).0;
                let mut each = diverged_lanes(&truth).into_iter().enumerate();
                if let Some((lane, at)) = each.find_map(|(lane, at)| Some((lane, at?))) {
                    return Err(self.at_fault(group, lane, at));
                }
            }
        }
        Ok(states)
    }

    /// Buffers for the states of a group.
    fn states(&self, group: &Group, wanted: Wanted) -> States {
        let states = || buffer(3 * (self.samples(group) + 1));
        let truth = if wanted >= Wanted::Truth { states() } else { Vec::new() };
        States { truth, measured: states(), exogenous: Vec::new(), commands: Vec::new() }
    }

    /// A group's recording, in the buffers of its states.
    fn recording<'s>(&self, group: &Group, truth: &'s mut [Lane], measured: &'s mut [Lane]) -> Recording<'s> {
        let (wind, rate_hz) = (self.wind.as_ref(), self.vessel.sample_rate_hz);
        let disturbing = self.disturbances.of_runs(wind, group.streams, group.numbers(), rate_hz);
        Recording { disturbing, truth, measured }
    }

    /// The states of a group of commanded runs, as [`Self::followed`].
    fn commanded(&self, group: &Group, wanted: Wanted) -> (States, Lane) {
        let model = &self.vessel.model;
        let mut states = self.states(group, wanted);
        let zeros = |width: usize| vec![Lane::ZERO; self.samples(group) * width];
        states.exogenous = zeros(model.exogenous().max(1));
        states.commands = if wanted == Wanted::Commands { zeros(model.inputs) } else { Vec::new() };
        let States { truth, measured, exogenous, commands } = &mut states;
        let recording = self.recording(group, truth, measured);
        let rate_hz = self.vessel.sample_rate_hz;
        let (truth, helms) = (&self.truth, &group.helms);
        let driving = Driving { exogenous, commands };
        let beyond = simulate_commanded(model, truth, group.start(), helms, rate_hz, recording, driving);
        (states, beyond)
    }

    /// The states, and a number above zero in lanes that diverge.
    fn followed<const G: usize>(&self, groups: [&Group; G], wanted: Wanted) -> ([States; G], [Lane; G]) {
        if groups.iter().any(|group| !group.helms.is_empty()) {
            let all = groups.map(|group| self.commanded(group, wanted));
            let beyond = all.each_ref().map(|(_, beyond)| *beyond);
            return (all.map(|(states, _)| states), beyond);
        }
        let model = &self.vessel.model;
        let alike = groups[0].shared().filter(|first| {
            groups.iter().all(|group| group.shared().is_some_and(|shared| std::ptr::eq(shared, *first)))
        });
        let lanes = |group: &Group| if alike.is_some() { Vec::new() } else { interleave(&group.exogenous) };
        let exogenous = groups.map(lanes);
        let driven = match alike {
            Some(shared) => Driven::SharedInputs(shared),
            None => Driven::Own(exogenous.each_ref().map(Vec::as_slice)),
        };
        let mut states = groups.map(|group| (group, self.states(group, wanted)));
        let recordings = states
            .each_mut()
            .map(|(group, States { truth, measured, .. })| self.recording(group, truth, measured));
        let start = groups.map(Group::start);
        let initial = [0, 1, 2].map(|d: usize| Wide(start.map(|state| state[d])));
        let beyond = simulate_disturbed(model, &self.truth, initial, driven, recordings);
        let mut exogenous = exogenous.into_iter();
        let states =
            states.map(|(_, states)| States { exogenous: exogenous.next().unwrap_or_default(), ..states });
        (states, beyond)
    }

    /// The part at fault if the run in `lane` diverges: the disturbances, if it does not diverge without them.
    fn at_fault(&self, group: &Group, lane: usize, at: Diverged) -> Refusal {
        let still = Disturbances { current: Current::None, ..self.disturbances };
        let bounded = |disturbances, wind| {
            let sea = Sea { vessel: self.vessel, truth: self.truth.clone(), disturbances, wind };
            let [beyond] = sea.followed([group], Wanted::Measured).1;
            beyond[lane] == 0.0
        };
        let run = format!("design {}, run {}", group.design, group.runs[lane]);
        if !bounded(still, None) {
            return Refusal::Vessel(at.invalid(format!("model in {run}"), self.vessel.sample_rate_hz));
        }
        let windy = self.wind.is_some() && bounded(self.disturbances, None);
        let key = if windy { "[wind]" } else { "`current.std_m_s`" };
        let expected = match windy {
            true => "a wind in which the motion stays bounded, as it does without wind",
            false => "a current in which the motion stays bounded, as it does in still water",
        };
        let thing = format!("{run}, which diverges in it at sample {}", at.sample);
        Refusal::Sea(Invalid::new(key, thing, expected, "lower it"))
    }

    fn samples(&self, group: &Group) -> usize {
        group.exogenous.first().map_or(0, |e| e.len() / self.vessel.model.exogenous().max(1))
    }
}

impl Group<'_> {
    fn numbers(&self) -> [u32; LANES] {
        by_lane(self.runs.len(), |run| self.runs[run])
    }

    /// The common inputs of all runs, if there are any.
    fn shared(&self) -> Option<&[f64]> {
        let first = *self.exogenous.first()?;
        self.exogenous.iter().all(|inputs| std::ptr::eq(*inputs, first)).then_some(first)
    }

    fn start(&self) -> [Lane; 3] {
        [0, 1, 2].map(|d: usize| lane(self.runs.len(), |run| self.initial[run][d]))
    }
}

/// Why a trial cannot be simulated, by the part at fault.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum Refusal {
    /// The vessel: a parameter without a true value, a motion that diverges.
    #[error("vessel: {0}")]
    Vessel(Invalid),
    /// The dictionary: a motion that the model cannot hold, limits that no maneuver keeps.
    #[error("dictionary: {0}")]
    Dictionary(Invalid),
    /// The campaign's numbers.
    #[error("campaign: {0}")]
    Campaign(Invalid),
    /// The current or the wind, if the vessel diverges only in these.
    #[error("sea: {0}")]
    Sea(Invalid),
    /// The design's shares or order.
    #[error("design: {0}")]
    Design(Invalid),
    /// The design has a maneuver that the dictionary does not have.
    #[error("design: found maneuver `{name}`, which the dictionary does not have")]
    UnknownManeuver {
        /// Its name.
        name: String,
        /// Whether it is in the design's order, or else in its shares.
        ordered: bool,
    },
    /// The design's order is for an experiment of another length.
    #[error("design: found an order of {ordered} samples, expected {samples}")]
    OtherLength {
        /// Samples of the order.
        ordered: usize,
        /// Samples of a run.
        samples: usize,
    },
}

/// The inputs of the nominal ship under the controllers of an experiment, in still water: the instruments of tracked motions. There
/// recorded inputs follow all that the controller saw.
#[derive(Clone, Debug, PartialEq)]
pub struct OwnLoop {
    /// N × exogenous, row-major.
    exogenous: Vec<f64>,
    /// The samples at which motions are tracked. Inputs that change when a heading is reached are instruments as they are: the
    /// nominal ship would reach it at another time.
    tracked: Vec<Range<usize>>,
}

impl OwnLoop {
    /// Of `parts`, each for so many samples, from `initial`; `None` where none of them tracks a motion.
    pub fn new(vessel: &Vessel, initial: [f64; 3], parts: &[(Helm, usize)]) -> Option<Self> {
        let mut end = 0;
        let mut range = |(helm, samples): &(Helm, usize)| {
            end += samples;
            helm.tracks().then_some(end - samples..end)
        };
        let tracked: Vec<Range<usize>> = parts.iter().filter_map(&mut range).collect();
        if tracked.is_empty() {
            return None;
        }
        let (model, rate_hz) = (&vessel.model, vessel.sample_rate_hz);
        let helm = Helm::sequence(parts.to_vec());
        let run = simulate_command(model, &vessel.nominal, initial, end, rate_hz, &helm);
        Some(Self { exogenous: run.exogenous, tracked })
    }

    /// What instruments are simulated with in a run with these `recorded` inputs and measured disturbances, N × exogenous.
    pub fn instruments(&self, model: &Model, recorded: &[f64]) -> Vec<f64> {
        let (width, inputs) = (model.exogenous(), model.inputs);
        let mut rows = recorded.to_vec();
        for k in self.tracked.iter().cloned().flatten() {
            let row = &mut rows[width * k..width * (k + 1)];
            row[..inputs].copy_from_slice(&self.exogenous[width * k..][..inputs]);
            model.complete(row);
        }
        rows
    }
}
