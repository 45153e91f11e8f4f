use std::sync::Arc;

use design::apportion;
use maneuver::Generator;
use numerics::lanes::{interleave, lane, lane_of, recycle};
use numerics::{LANES, Lane};
use ship::engine::{Helm, Run, Segment, SideBySide, check_diverged, simulate_command, simulate_one};
use ship::model::{Model, Source, Vessel};

use super::designed::{Parts, Plan, Tables};
use super::sea::{OwnLoop, SimulatedRun, States};

/// The planned content of a run, without disturbances.
#[derive(Clone, Debug, PartialEq)]
pub struct Experiment {
    /// Its segments, in order.
    pub segments: Vec<Segment>,
    /// State at the start: u, v \[m/s\], r \[rad/s\].
    pub initial: [f64; 3],
    /// Inputs, and measured disturbances of zero: N × exogenous, row-major.
    pub exogenous: Vec<f64>,
    /// Its commands, if they depend on the ship's motion. Then the above are those of an undisturbed ship.
    pub helm: Option<Helm>,
    /// The instruments of motions that it tracks.
    pub own_loop: Option<OwnLoop>,
}

/// Up to [`LANES`] simulated runs of one design, in lanes.
pub struct Together<'a> {
    pub(super) model: &'a Model,
    pub(super) design: &'static str,
    /// Number of the first.
    pub(super) first: u32,
    /// The experiment of each; a single one, if all have the same.
    pub(super) experiments: Vec<Arc<Experiment>>,
    pub(super) states: States,
}

impl Together<'_> {
    /// How many runs there are.
    pub fn runs(&self) -> usize {
        self.experiments.len()
    }

    /// Number of a run.
    fn number(&self, lane: usize) -> i32 {
        self.first as i32 + lane as i32
    }

    /// Measured states, (N+1) × 3.
    pub fn measured(&self) -> &[Lane] {
        &self.states.measured
    }

    /// First samples of the segments of each.
    pub fn starts(&self) -> Vec<Vec<usize>> {
        let of_run = |one: &Arc<Experiment>| one.segments.iter().map(|segment| segment.start).collect();
        self.experiments.iter().map(of_run).collect()
    }

    /// The runs in the form that estimators take.
    pub fn side_by_side(self) -> SideBySide {
        let rows = || self.experiments.iter().map(|one| one.exogenous.as_slice()).collect::<Vec<_>>();
        let instrument_exogenous = self.instrument_exogenous();
        let known = self.states.exogenous;
        SideBySide {
            runs: self.experiments.len(),
            instrument_exogenous,
            exogenous: if known.is_empty() { interleave(&rows()) } else { known },
            initial: [0, 1, 2]
                .map(|d: usize| lane(self.experiments.len(), |run| self.experiments[run].initial[d])),
            samples: [self.states.measured.len() / 3 - 1; LANES],
            measured: self.states.measured,
        }
    }

    /// What instruments are simulated with, N × exogenous; empty where that are the recorded inputs of all runs.
    fn instrument_exogenous(&self) -> Vec<Lane> {
        if self.experiments.iter().all(|experiment| experiment.own_loop.is_none()) {
            return Vec::new();
        }
        let rows = |(lane, experiment): (usize, &Arc<Experiment>)| {
            let recorded = lane_of(&self.states.exogenous, lane);
            match &experiment.own_loop {
                Some(own_loop) => own_loop.instruments(self.model, &recorded),
                None => recorded,
            }
        };
        let rows: Vec<Vec<f64>> = self.experiments.iter().enumerate().map(rows).collect();
        interleave(&rows.iter().map(Vec::as_slice).collect::<Vec<_>>())
    }

    /// Recycles the buffer of the states.
    pub fn recycle(self) {
        recycle([self.states.measured]);
    }

    /// A run by itself.
    pub fn run(&self, lane: usize) -> SimulatedRun {
        let [states, measured] = self.states.of(lane);
        let Experiment { segments, initial, exogenous, helm, own_loop } = &*self.experiments[lane];
        let exogenous = match helm {
            None => exogenous.clone(),
            Some(_) => lane_of(&self.states.exogenous, lane),
        };
        let of_loop = |own_loop: &OwnLoop| own_loop.instruments(self.model, &exogenous);
        let instruments = own_loop.as_ref().map(of_loop).unwrap_or_default();
        let run = Run {
            design: self.design.to_owned(),
            run: self.number(lane),
            segments: segments.clone(),
            exogenous,
            instrument_exogenous: instruments,
            measured,
            initial: *initial,
        };
        SimulatedRun { run, states, commands: lane_of(&self.states.commands, lane) }
    }
}

/// Experiments of `samples` samples of today's practice, with their parts; or why there are none, for users.
///
/// A round has the maneuvers that are written by hand, in the dictionary's order and at their own lengths. Rounds are repeated and the
/// last one is cut; a round longer than the experiment is shortened, all its maneuvers alike. Tables of inputs are played whole or left
/// out.
pub(crate) fn practice(generator: &Generator, samples: usize) -> Result<(Plan, Parts), String> {
    let written = 0..generator.written();
    if written.len() < 2 {
        let has = generator.maneuvers()[written]
            .first()
            .map_or("none".to_owned(), |maneuver| format!("only `{}`", maneuver.name));
        return Err(format!("they take two hand-written maneuvers or more, and the dictionary has {has}"));
    }
    let lengths = written.into_iter().map(|q| generator.samples(q).map(|n| (q, n)));
    let round: Plan = lengths.collect::<Result<_, _>>().map_err(|e| e.to_string())?;
    let plan = repeated(&round, generator.tables(), samples)
        .ok_or("whole plays of the dictionary's tables do not fill them")?;
    let mut parts = Parts::default();
    parts.make(generator, &plan).map_err(|e| e.to_string())?;
    Ok((plan, parts))
}

/// `round` in turn in `samples` samples; `None` if tables leave samples that nothing fills.
fn repeated(round: &[(usize, usize)], tables: &Tables, samples: usize) -> Option<Plan> {
    let length = |round: &[(usize, usize)]| round.iter().map(|(_, n)| n).sum::<usize>();
    let is_cut = |(q, _): &&(usize, usize)| !tables.contains_key(q);
    if length(round) > samples {
        let round: Plan = round.iter().filter(is_cut).copied().collect();
        let whole = length(&round);
        if whole > samples {
            let shares: Vec<f64> = round.iter().map(|(_, n)| *n as f64 / whole as f64).collect();
            let counts = apportion(&shares, samples as u64).into_iter().map(|n| n as usize);
            return Some(round.iter().map(|(q, _)| *q).zip(counts).filter(|(_, n)| *n > 0).collect());
        }
    }
    let (mut plan, mut rest) = (Plan::new(), samples);
    while rest > 0 {
        let before = rest;
        for (q, n) in round {
            let taken = if *n > rest && tables.contains_key(q) { 0 } else { rest.min(*n) };
            plan.extend((taken > 0).then_some((*q, taken)));
            rest -= taken;
        }
        if rest == before {
            return None;
        }
    }
    Some(plan)
}

/// Why the undisturbed ship cannot sail `experiment`, for users: the maneuver in which she diverges.
pub(super) fn not_sailed(vessel: &Vessel, experiment: &Experiment) -> Option<String> {
    let (model, rate_hz) = (&vessel.model, vessel.sample_rate_hz);
    let truth = vessel.parameters(Source::Value).ok()?;
    let states = match &experiment.helm {
        None => simulate_one(model, &truth, experiment.initial, &experiment.exogenous),
        Some(helm) => {
            let samples = experiment.exogenous.len() / model.exogenous().max(1);
            simulate_command(model, &truth, experiment.initial, samples, rate_hz, helm).states
        }
    };
    let at = check_diverged(states.into_iter())?;
    let segment = experiment.segments.iter().rev().find(|segment| segment.start < at.sample.max(1))?;
    let after_s = at.sample as f64 / rate_hz;
    Some(format!("the ship diverges in maneuver `{}`, {after_s:.1} s after their start", segment.maneuver))
}
