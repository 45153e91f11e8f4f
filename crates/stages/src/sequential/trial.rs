use std::path::Path;

use identification::parameter_error;
use optimal_design::apportion;
use vessel::{Generator, Streams, check_diverged, simulate_one};

use super::knowledge::Knowledge;
use super::planner::Planner;
use super::table::{Outcome, Row, Shared};
use super::voyage::Voyage;
use crate::estimators::RunEstimators;
use crate::failure::Failure;
use crate::lanes::lane_of;
use crate::simulate::campaign::{MANEUVER_CHANNEL, Plan};
use crate::simulate::sea::{Departures, Sea};
use crate::trajectories::Run;

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

    /// Rounds in order: plan, sail, estimate, learn. The sequential trial is one voyage that grows; the others are laid out
    /// for the time that they end after.
    fn arm(&self, arm: Arm, starts: &[Start]) -> Result<Vec<Row>, Failure> {
        let vessel = self.sea.vessel();
        let mut known: Vec<Vec<f64>> = starts.iter().map(|s| self.first_model(arm, s)).collect();
        let mut voyages = vec![Voyage::default(); starts.len()];
        let mut rows = Vec::with_capacity(starts.len() * self.ends.len());
        for (round, end) in self.ends.iter().enumerate() {
            let mut before = Vec::with_capacity(starts.len());
            for ((start, voyage), known) in starts.iter().zip(&mut voyages).zip(&known) {
                if arm != Arm::Sequential {
                    *voyage = Voyage::default();
                }
                let coming = end - voyage.samples(vessel);
                let (plan, shared) = self.plan(arm, start, known, voyage, coming);
                let went = voyage.go_on(vessel, self.generator, &plan);
                went.map_err(|e| Failure::invalid(self.dictionary_file, &e))?;
                before.push((shared, self.expected(arm, known, voyage)));
            }
            let found = self.found(arm, starts, &voyages)?;
            for (lane, (found, (shared, expected_error))) in found.into_iter().zip(before).enumerate() {
                let learnt = found
                    .estimate
                    .as_ref()
                    .map(|(theta, errors)| self.knowledge.learnt(&starts[lane].crude, theta, errors));
                rows.push(Row {
                    arm,
                    realization: starts[lane].number,
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
                        .zip(learnt.as_ref())
                        .map(|((_, errors), learnt)| self.knowledge.relative(errors, learnt)),
                    expected_error,
                });
                if let (Arm::Sequential, Some(learnt)) = (arm, learnt) {
                    known[lane] = learnt;
                }
            }
        }
        Ok(rows)
    }

    /// The model that the first plan is made with.
    fn first_model(&self, arm: Arm, start: &Start) -> Vec<f64> {
        if arm == Arm::Informed { self.truth.clone() } else { start.crude.clone() }
    }

    /// What the coming samples hold, and how it was chosen.
    fn plan(&self, arm: Arm, start: &Start, known: &[f64], so_far: &Voyage, coming: usize) -> (Plan, Shared) {
        let first = so_far.exogenous.is_empty();
        let shares = match arm {
            Arm::Random => return (self.drawn(start.number, coming), Shared::Drawn),
            Arm::Informed => Some(self.informed.clone()),
            Arm::Sequential if !first => {
                self.planner.shares(known, &self.knowledge.sizes(known), so_far, coming)
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
    fn expected(&self, arm: Arm, known: &[f64], voyage: &Voyage) -> Option<f64> {
        if arm != Arm::OneShot {
            return None;
        }
        let errors = self.planner.standard_errors(known, &self.knowledge.sizes(known), voyage)?;
        Some(self.knowledge.relative(&errors, known))
    }

    /// Sails all voyages side by side and estimates from each. All arms meet the same disturbances in a realization.
    fn found(&self, arm: Arm, starts: &[Start], voyages: &[Voyage]) -> Result<Vec<Found>, Failure> {
        let runs: Vec<u32> = starts.iter().map(|start| start.number).collect();
        let sailed = self.sea.sail(&Departures {
            design: arm.name(),
            streams: &Streams::new(self.seed, "trial"),
            runs: &runs,
            initial: voyages.iter().map(|voyage| voyage.initial).collect(),
            exogenous: voyages.iter().map(|voyage| voyage.exogenous.as_slice()).collect(),
        })?;
        let run = |(lane, voyage): (usize, &Voyage)| {
            voyage.run(self.generator, arm.name(), runs[lane], lane_of(&sailed.measured, lane))
        };
        let runs: Vec<Run> = voyages.iter().enumerate().map(run).collect();
        let bounded: Vec<bool> = voyages.iter().map(|voyage| self.bounded(voyage)).collect();
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
