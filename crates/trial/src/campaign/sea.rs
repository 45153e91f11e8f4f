use vessel::lanes::{by_lane, interleave, lane, lane_of};
use vessel::{
    Current, Disturbances, Diverged, Invalid, LANES, Lane, Run, Source, Streams, Vessel, Weather, Wind,
    check_diverged, simulate,
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
        let truth = self.truth(group);
        for lane in 0..group.runs.len() {
            if let Some(at) = check_diverged(truth.iter().map(|s| s[lane])) {
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
        let Group { streams, exogenous, .. } = group;
        let (model, rate_hz, numbers) = (&self.vessel.model, self.vessel.sample_rate_hz, group.numbers());
        let samples = exogenous.first().map_or(0, |e| e.len() / model.exogenous().max(1));
        let (start, lanes) = (group.start(), interleave(exogenous));
        let current = self.disturbances.current(streams, numbers, samples, rate_hz);
        let mut states = vec![Lane::ZERO; 3 * (samples + 1)];
        let turning = if self.disturbances.current.in_earth_axes() { 1.0 / rate_hz } else { 0.0 };
        let force = self.wind.as_ref().map(|w| w.force(streams, numbers, samples, rate_hz));
        let weather = Weather { current: &current, turning, force: &force.unwrap_or_default() };
        simulate(model, &self.truth, start, &lanes, &weather, &mut states);
        states
    }
}

impl Group<'_> {
    fn numbers(&self) -> [u32; LANES] {
        by_lane(self.runs.len(), |run| self.runs[run])
    }

    fn start(&self) -> [Lane; 3] {
        [0, 1, 2].map(|d: usize| lane(self.runs.len(), |run| self.initial[run][d]))
    }
}
