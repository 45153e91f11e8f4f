use vessel::lanes::{by_lane, interleave, lane, lane_of};
use vessel::{
    Current, Disturbances, Diverged, GROUPS, Invalid, LANES, Lane, Run, Source, Streams, Vessel, Weather,
    Wind, check_diverged, diverged_lanes, simulate, simulate_groups,
};

use super::Refusal;

/// The true vessel and what disturbs it. Simulates up to [`LANES`] runs side by side.
pub struct Sea<'a> {
    vessel: &'a Vessel,
    truth: Vec<Lane>,
    disturbances: Disturbances,
    wind: Option<Wind>,
}

/// Runs of one design that are simulated side by side.
pub struct Group<'a> {
    /// Name of the design.
    pub design: &'a str,
    /// What the disturbances are drawn from.
    pub streams: &'a Streams,
    /// Numbers of the runs, up to [`LANES`].
    pub runs: &'a [u32],
    /// Initial state of each: u, v \[m/s\], r \[rad/s\].
    pub initial: Vec<[f64; 3]>,
    /// Of each, N × exogenous, row-major; N is the same for all.
    pub exogenous: Vec<&'a [f64]>,
}

/// States of a group's runs, (N+1) × 3, row-major.
pub struct States {
    /// The true ones.
    pub truth: Vec<Lane>,
    /// With measurement noise.
    pub measured: Vec<Lane>,
}

/// A run as it would be recorded, with the truth behind it.
#[derive(Clone, Debug, PartialEq)]
pub struct SimulatedRun {
    /// The recording.
    pub run: Run,
    /// True states, (N+1) × 3, row-major.
    pub states: Vec<f64>,
}

impl States {
    /// True and measured states of one run, (N+1) × 3.
    pub fn of(&self, lane: usize) -> [Vec<f64>; 2] {
        [&self.truth, &self.measured].map(|states| lane_of(states, lane))
    }
}

impl<'a> Sea<'a> {
    /// The true parameters of `vessel` among these disturbances.
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

    /// Simulates a group. What disturbs a run's first samples does not depend on how long it is.
    ///
    /// # Errors
    /// A vessel whose motion diverges, or disturbances that let it.
    pub fn simulate(&self, group: &Group) -> Result<States, Refusal> {
        self.measured(group, self.truth(group))
    }

    /// Simulates groups of runs that all start and do the same.
    ///
    /// # Errors
    /// See [`Self::simulate`].
    pub(super) fn simulate_alike(&self, groups: &[Group; GROUPS]) -> Result<Vec<States>, Refusal> {
        let Group { initial, exogenous, .. } = &groups[0];
        let weather = groups.each_ref().map(|group| self.weather(group));
        let mut truths = groups.each_ref().map(|group| vec![Lane::ZERO; 3 * (self.samples(group) + 1)]);
        simulate_groups(
            &self.vessel.model,
            &self.truth,
            initial[0],
            exogenous[0],
            weather.each_ref().map(|own| self.acting(own)),
            truths.each_mut().map(Vec::as_mut_slice),
        );
        groups.iter().zip(truths).map(|(group, truth)| self.measured(group, truth)).collect()
    }

    /// A group whose true states are known.
    fn measured(&self, group: &Group, truth: Vec<Lane>) -> Result<States, Refusal> {
        for (lane, at) in diverged_lanes(&truth).into_iter().enumerate().take(group.runs.len()) {
            if let Some(at) = at {
                return Err(self.at_fault(group, lane, at));
            }
        }
        let mut measured = truth.clone();
        self.disturbances.measure(group.streams, group.numbers(), &mut measured);
        Ok(States { truth, measured })
    }

    /// What is at fault where the run in `lane` diverges: the disturbances, where it does not without them.
    fn at_fault(&self, group: &Group, lane: usize, at: Diverged) -> Refusal {
        let still = Disturbances { current: Current::None, ..self.disturbances };
        let bounded = |disturbances, wind| {
            let sea = Sea { vessel: self.vessel, truth: self.truth.clone(), disturbances, wind };
            check_diverged(sea.truth(group).iter().map(|s| s[lane])).is_none()
        };
        let run = format!("design {}, run {}", group.design, group.runs[lane]);
        if !bounded(still, None) {
            return Refusal::Vessel(at.invalid(format!("model in {run}")));
        }
        let windy = self.wind.is_some() && bounded(self.disturbances, None);
        let (key, expected) = match windy {
            true => ("[wind]", "a wind in which the motion stays bounded, as it does without wind"),
            false => (
                "`current.std_m_s`",
                "a current in which the motion stays bounded, as it does in still water",
            ),
        };
        let found = format!("{run}, which diverges in it at sample {}", at.sample);
        Refusal::Sea(Invalid::new(key, found, expected, "lower it"))
    }

    fn truth(&self, group: &Group) -> Vec<Lane> {
        let (model, drawn) = (&self.vessel.model, self.weather(group));
        let mut states = vec![Lane::ZERO; 3 * (self.samples(group) + 1)];
        let (start, weather) = (group.start(), self.acting(&drawn));
        match group.shared() {
            Some(shared) => simulate(model, &self.truth, start, shared, &weather, &mut states),
            None => {
                let lanes = interleave(&group.exogenous);
                simulate(model, &self.truth, start, &lanes, &weather, &mut states);
            }
        }
        states
    }

    fn samples(&self, group: &Group) -> usize {
        group.exogenous.first().map_or(0, |e| e.len() / self.vessel.model.exogenous().max(1))
    }

    /// The current of a group's runs, and the wind's force.
    fn weather(&self, group: &Group) -> [Vec<Lane>; 2] {
        let (streams, numbers, rate_hz) = (group.streams, group.numbers(), self.vessel.sample_rate_hz);
        let samples = self.samples(group);
        let force = self.wind.as_ref().map(|w| w.force(streams, numbers, samples, rate_hz));
        [self.disturbances.current(streams, numbers, samples, rate_hz), force.unwrap_or_default()]
    }

    fn acting<'w>(&self, [current, force]: &'w [Vec<Lane>; 2]) -> Weather<'w> {
        let earth = self.disturbances.current.in_earth_axes();
        Weather { current, turning: if earth { 1.0 / self.vessel.sample_rate_hz } else { 0.0 }, force }
    }
}

impl Group<'_> {
    fn numbers(&self) -> [u32; LANES] {
        by_lane(self.runs.len(), |run| self.runs[run])
    }

    /// What all runs have, where it is the same.
    fn shared(&self) -> Option<&[f64]> {
        let first = *self.exogenous.first()?;
        self.exogenous.iter().all(|own| std::ptr::eq(*own, first)).then_some(first)
    }

    fn start(&self) -> [Lane; 3] {
        [0, 1, 2].map(|d: usize| lane(self.runs.len(), |run| self.initial[run][d]))
    }
}
