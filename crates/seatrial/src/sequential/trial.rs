use std::path::Path;

use design::apportion;
use identification::parameter_error;
use vessel::{Generator, Streams, check_diverged, simulate_one};

use super::knowledge::Knowledge;
use super::planner::Planner;
use super::table::{Outcome, Row, Shared};
use super::voyage::Voyage;
use crate::estimators::RunEstimators;
use crate::failure::Failure;
use crate::simulate::campaign::{MANEUVER_CHANNEL, Plan};
use crate::simulate::sea::{Departures, Sea};
use vessel::Run;
use vessel::lanes::lane_of;

/// A way to spend the sea time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Arm {
    /// Designed anew for every round, with what the rounds before have told.
    Sequential,
    /// Designed once, from the crude model.
    OneShot,
    /// Designed once, from the true parameters: what nobody can do.
    Informed,
    /// Maneuvers drawn at random.
    Random,
}

impl Arm {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Sequential, Self::OneShot, Self::Informed, Self::Random];

    /// As in files.
    pub fn name(self) -> &'static str {
        ["sequential", "one-shot", "informed", "random"][self as usize]
    }
}

/// What all realizations share.
pub(super) struct Trial<'a> {
    /// What is sailed in.
    pub sea: Sea<'a>,
    /// The maneuvers.
    pub generator: &'a Generator,
    /// For messages.
    pub dictionary_file: &'a Path,
    /// Designs.
    pub planner: Planner<'a>,
    /// Estimates: output error.
    pub estimators: RunEstimators<'a>,
    /// Crude models, and what is learnt.
    pub knowledge: Knowledge,
    /// True parameters.
    pub truth: Vec<f64>,
    /// The design from them.
    pub informed: Vec<f64>,
    /// Samples sailed by the end of every round.
    pub ends: Vec<usize>,
    /// Segments of a random experiment.
    pub random_segments: usize,
    /// Seed of all random numbers.
    pub seed: u64,
}

/// A realization before it sails.
struct Start {
    number: u32,
    crude: Vec<f64>,
    /// The design from the crude model: the one-shot trial's, and of the first round.
    shares: Option<Vec<f64>>,
}

/// A realization at sea.
struct Aboard<'a> {
    start: &'a Start,
    /// Parameters of the model that plans.
    known: Vec<f64>,
    voyage: Voyage,
}

/// An estimate of a voyage.
struct Found {
    outcome: Outcome,
    /// θ̂ and standard errors.
    estimate: Option<(Vec<f64>, Vec<f64>)>,
}

impl Trial<'_> {
    /// The rows of realizations `numbers`, which sail side by side: realizations, arms, rounds in order.
    ///
    /// # Errors
    /// A maneuver that the model cannot hold; a true vessel that diverges; a run too short for its unknowns.
    pub fn realizations(&self, numbers: std::ops::Range<u32>) -> Result<Vec<Row>, Failure> {
        let starts: Vec<Start> = numbers.map(|number| self.start(number)).collect();
        let mut rows = Vec::with_capacity(starts.len() * Arm::ALL.len() * self.ends.len());
        for arm in Arm::ALL {
            rows.extend(self.arm(arm, &starts)?);
        }
        rows.sort_by_key(|row| (row.realization, row.arm as usize, row.round));
        Ok(rows)
    }

    fn start(&self, number: u32) -> Start {
        let crude = self.knowledge.crude(number);
        let sizes = self.knowledge.sizes(&crude);
        let shares = self.planner.shares(&crude, &sizes, &Voyage::default(), self.ends[0]);
        Start { number, crude, shares }
    }

    /// Rounds in order: plan, sail, estimate, learn.
    fn arm(&self, arm: Arm, starts: &[Start]) -> Result<Vec<Row>, Failure> {
        let begin = |start| Aboard { start, known: self.first_model(arm, start), voyage: Voyage::default() };
        let mut all: Vec<Aboard> = starts.iter().map(begin).collect();
        let mut rows = Vec::with_capacity(starts.len() * self.ends.len());
        for (round, end) in self.ends.iter().enumerate() {
            let mut before = Vec::with_capacity(starts.len());
            for aboard in &mut all {
                let shared = self.go_on(arm, aboard, *end)?;
                before.push((shared, self.expected(arm, aboard)));
            }
            let found = self.found(arm, &all)?;
            for ((aboard, found), (shared, expected_error)) in all.iter_mut().zip(found).zip(before) {
                rows.push(Row {
                    arm,
                    realization: aboard.start.number,
                    round: round as u32,
                    samples: *end,
                    shared,
                    outcome: found.outcome,
                    parameter_error: found
                        .estimate
                        .as_ref()
                        .and_then(|(t, _)| parameter_error(t, &self.truth)),
                    predicted_error: found
                        .estimate
                        .as_ref()
                        .map(|(t, errors)| self.learn(arm, aboard, t, errors)),
                    expected_error,
                });
            }
        }
        Ok(rows)
    }

    /// Plans and adds what is sailed until `end`. The sequential trial is one voyage that grows; the others are laid out for
    /// the time that they end after.
    fn go_on(&self, arm: Arm, aboard: &mut Aboard, end: usize) -> Result<Shared, Failure> {
        let vessel = self.sea.vessel();
        if arm != Arm::Sequential {
            aboard.voyage = Voyage::default();
        }
        let coming = end - aboard.voyage.samples(vessel);
        let (plan, shared) = self.plan(arm, aboard, coming);
        let went = aboard.voyage.go_on(vessel, self.generator, &plan);
        went.map_err(|e| Failure::invalid(self.dictionary_file, &e))?;
        Ok(shared)
    }

    /// The error that an estimate promises of itself; in rounds the next is planned with what is learnt.
    fn learn(&self, arm: Arm, aboard: &mut Aboard, theta: &[f64], standard_errors: &[f64]) -> f64 {
        let learnt = self.knowledge.learnt(&aboard.start.crude, theta, standard_errors);
        let promised = self.knowledge.relative(standard_errors, &learnt);
        if arm == Arm::Sequential {
            aboard.known = learnt;
        }
        promised
    }

    /// The model that the first plan is made with.
    fn first_model(&self, arm: Arm, start: &Start) -> Vec<f64> {
        if arm == Arm::Informed { self.truth.clone() } else { start.crude.clone() }
    }

    /// What the coming samples hold, and how it was chosen.
    fn plan(&self, arm: Arm, aboard: &Aboard, coming: usize) -> (Plan, Shared) {
        let Aboard { start, known, voyage } = aboard;
        let first = voyage.exogenous.is_empty();
        let shares = match arm {
            Arm::Random => return (self.drawn(start.number, coming), Shared::Drawn),
            Arm::Informed => Some(self.informed.clone()),
            Arm::Sequential if !first => {
                self.planner.shares(known, &self.knowledge.sizes(known), voyage, coming)
            }
            Arm::Sequential | Arm::OneShot => start.shares.clone(),
        };
        let shared = if shares.is_some() { Shared::Designed } else { Shared::Even };
        let maneuvers = self.planner.maneuvers();
        let shares = shares.unwrap_or_else(|| vec![1.0 / maneuvers.len() as f64; maneuvers.len()]);
        let counts = apportion(&shares, coming as u64);
        (maneuvers.zip(counts).filter(|(_, n)| *n > 0).map(|(q, n)| (q, n as usize)).collect(), shared)
    }

    /// Equally long segments, each of them any maneuver.
    fn drawn(&self, number: u32, samples: usize) -> Plan {
        let segments = self.random_segments.min(samples).max(1);
        let lengths = apportion(&vec![1.0 / segments as f64; segments], samples as u64);
        let streams = Streams::new(self.seed, &format!("random {samples}"));
        let maneuvers: Vec<usize> = self.planner.maneuvers().collect();
        let drawn = streams.choices(number, MANEUVER_CHANNEL, maneuvers.len() as u32, segments);
        drawn.into_iter().zip(lengths).map(|(q, n)| (maneuvers[q as usize], n as usize)).collect()
    }

    /// The error after `voyage` that the crude model expects, by which a one-shot trial is sized.
    fn expected(&self, arm: Arm, aboard: &Aboard) -> Option<f64> {
        if arm != Arm::OneShot {
            return None;
        }
        let Aboard { known, voyage, .. } = aboard;
        let errors = self.planner.standard_errors(known, &self.knowledge.sizes(known), voyage)?;
        Some(self.knowledge.relative(&errors, known))
    }

    /// Sails all voyages side by side and estimates from each. All arms meet the same disturbances in a realization.
    fn found(&self, arm: Arm, all: &[Aboard]) -> Result<Vec<Found>, Failure> {
        let numbers: Vec<u32> = all.iter().map(|aboard| aboard.start.number).collect();
        let sailed = self.sea.sail(&Departures {
            design: arm.name(),
            streams: &Streams::new(self.seed, "trial"),
            runs: &numbers,
            initial: all.iter().map(|aboard| aboard.voyage.initial).collect(),
            exogenous: all.iter().map(|aboard| aboard.voyage.exogenous.as_slice()).collect(),
        })?;
        let run = |(lane, aboard): (usize, &Aboard)| {
            let measured = lane_of(&sailed.measured, lane);
            aboard.voyage.run(self.generator, arm.name(), numbers[lane], measured)
        };
        let runs: Vec<Run> = all.iter().enumerate().map(run).collect();
        let bounded: Vec<bool> = all.iter().map(|aboard| self.bounded(&aboard.voyage)).collect();
        let kept: Vec<Run> =
            runs.into_iter().zip(&bounded).filter(|(_, b)| **b).map(|(run, _)| run).collect();
        let mut rows = self.estimators.rows(&kept)?.into_iter();
        let found = |bounded: &bool| match bounded.then(|| rows.next()).flatten() {
            None => Found { outcome: Outcome::Diverged, estimate: None },
            Some(row) => Found { outcome: row.status.into(), estimate: row.estimate },
        };
        Ok(bounded.iter().map(found).collect())
    }

    /// Whether instruments can be simulated: the nominal model stays bounded.
    fn bounded(&self, voyage: &Voyage) -> bool {
        let vessel = self.sea.vessel();
        let states = simulate_one(&vessel.model, &vessel.nominal, voyage.initial, &voyage.exogenous);
        check_diverged(states.into_iter()).is_none()
    }
}
