use design::apportion;
use identification::runs::{RunError, RunEstimators};
use identification::{Noise, RunEstimate, parameter_error};
use vessel::{
    Generator, Invalid, LANES, Run, Source, Streams, Vessel, check_diverged, refuse_endless, simulate_one,
};

use super::growing_run::GrowingRun;
use super::knowledge::Knowledge;
use super::planner::Planner;
use super::row::{Arm, Outcome, Row, Shared};
use crate::campaign::{Group, Parts, Plan, Refusal, Sea, even_lengths, random_segments};

/// What all realizations share.
pub struct Trial<'a> {
    sea: Sea<'a>,
    generator: &'a Generator,
    planner: Planner<'a>,
    estimators: RunEstimators<'a>,
    knowledge: Knowledge,
    truth: Vec<f64>,
    /// The design from the true parameters.
    informed: Vec<f64>,
    ends: Vec<usize>,
    random_segments: usize,
}

/// A realization before its trial.
struct Start {
    number: u32,
    crude: Vec<f64>,
    /// The design from the crude model: the one-shot trial's, and of the first round.
    shares: Option<Vec<f64>>,
}

/// The estimates of realizations, nothing where the nominal model diverges.
type Found = Vec<Option<RunEstimate>>;

/// A realization in its trial.
struct Realization<'a> {
    start: &'a Start,
    /// Parameters of the model that plans.
    known: Vec<f64>,
    run: GrowingRun,
}

impl<'a> Trial<'a> {
    /// `noise`: the levels that designs and expected errors are predicted from; `estimators`: the one whose estimates runs
    /// get; `ends`: samples by the end of every round;
    /// `random_segments`: segments of a random experiment.
    ///
    /// # Errors
    /// A vessel without a truth that errors can be relative to; maneuvers that the model cannot hold, or that do not excite
    /// every parameter.
    pub fn new(
        sea: Sea<'a>,
        generator: &'a Generator,
        noise: Noise,
        estimators: RunEstimators<'a>,
        knowledge: Knowledge,
        ends: Vec<usize>,
        random_segments: usize,
    ) -> Result<Self, Refusal> {
        let truth = truth(sea.vessel()).map_err(Refusal::Vessel)?;
        let planner = Planner::new(sea.vessel(), generator, noise).map_err(Refusal::Dictionary)?;
        let informed = planner
            .shares(&truth, &knowledge.sizes(&truth), &GrowingRun::default(), ends[0])
            .ok_or_else(|| Refusal::Dictionary(unexcited()))?;
        Ok(Self { sea, generator, planner, estimators, knowledge, truth, informed, ends, random_segments })
    }

    /// Samples by the end of every round.
    pub fn ends(&self) -> &[usize] {
        &self.ends
    }

    /// Number of maneuvers to design with.
    pub fn maneuvers(&self) -> usize {
        self.planner.maneuvers().len()
    }

    /// The rows of realizations `numbers`, which are estimated side by side: realizations, arms, rounds in order.
    ///
    /// # Errors
    /// A maneuver that the model cannot hold; a true vessel that diverges; a run too short for its unknowns.
    pub fn realizations(&self, numbers: std::ops::Range<u32>) -> Result<Vec<Row>, Refusal> {
        let starts: Vec<Start> = numbers.map(|number| self.start(number)).collect();
        let mut rows = Vec::with_capacity(starts.len() * Arm::ALL.len() * self.ends.len());
        let mut first = None;
        for arm in Arm::ALL {
            rows.extend(self.arm(arm, &starts, &mut first)?);
        }
        rows.sort_by_key(|row| (row.realization, row.arm as usize, row.round));
        Ok(rows)
    }

    fn start(&self, number: u32) -> Start {
        let crude = self.knowledge.crude(number);
        let sizes = self.knowledge.sizes(&crude);
        let shares = self.planner.shares(&crude, &sizes, &GrowingRun::default(), self.ends[0]);
        Start { number, crude, shares }
    }

    /// Rounds in order: plan, run, estimate, learn. `first`: what is found in the first round of a design from the crude model,
    /// which two arms begin with, once it is known.
    fn arm(&self, arm: Arm, starts: &[Start], first: &mut Option<Found>) -> Result<Vec<Row>, Refusal> {
        let begin =
            |start| Realization { start, known: self.first_model(arm, start), run: GrowingRun::default() };
        let mut all: Vec<Realization> = starts.iter().map(begin).collect();
        let mut rows = Vec::with_capacity(starts.len() * self.ends.len());
        let mut parts = Parts::default();
        for (round, end) in self.ends.iter().enumerate() {
            let mut before = Vec::with_capacity(starts.len());
            for realization in &mut all {
                let shared = self.go_on(arm, realization, &mut parts, *end)?;
                before.push((shared, self.expected(arm, realization)));
            }
            let found = match round {
                0 if arm.begins_crudely() => match first.take() {
                    Some(found) => found,
                    None => first.insert(self.found(arm, &all)?).clone(),
                },
                _ => self.found(arm, &all)?,
            };
            for ((realization, found), (shared, expected_error)) in all.iter_mut().zip(found).zip(before) {
                let estimate = found.as_ref().and_then(|found| found.estimate.as_ref());
                rows.push(Row {
                    arm,
                    realization: realization.start.number,
                    round: round as u32,
                    samples: *end,
                    shared,
                    outcome: found.as_ref().map_or(Outcome::Diverged, |found| found.status.into()),
                    parameter_error: estimate.and_then(|(t, _)| parameter_error(t, &self.truth)),
                    predicted_error: estimate.map(|(t, errors)| self.learn(arm, realization, t, errors)),
                    expected_error,
                });
            }
        }
        Ok(rows)
    }

    /// Plans the time until `end`. The sequential trial is one run that grows; the others are laid out for the time that
    /// they end after.
    fn go_on(
        &self,
        arm: Arm,
        realization: &mut Realization,
        parts: &mut Parts,
        end: usize,
    ) -> Result<Shared, Refusal> {
        let vessel = self.sea.vessel();
        if arm != Arm::Sequential {
            realization.run = GrowingRun::default();
        }
        let coming = end - realization.run.samples(vessel);
        let (plan, shared) = self.plan(arm, realization, coming);
        let went = realization.run.go_on(vessel, self.generator, parts, &plan);
        went.map_err(Refusal::Dictionary)?;
        Ok(shared)
    }

    /// The error that an estimate promises of itself; in rounds the next is planned with what is learnt.
    fn learn(&self, arm: Arm, realization: &mut Realization, theta: &[f64], standard_errors: &[f64]) -> f64 {
        let learnt = self.knowledge.learnt(&realization.start.crude, theta, standard_errors);
        let promised = self.knowledge.relative(standard_errors, &learnt);
        if arm == Arm::Sequential {
            realization.known = learnt;
        }
        promised
    }

    /// The model that the first plan is made with.
    fn first_model(&self, arm: Arm, start: &Start) -> Vec<f64> {
        if arm == Arm::Informed { self.truth.clone() } else { start.crude.clone() }
    }

    /// What the coming samples hold, and how it was chosen.
    fn plan(&self, arm: Arm, realization: &Realization, coming: usize) -> (Plan, Shared) {
        let Realization { start, known, run } = realization;
        let first = run.exogenous.is_empty();
        let shares = match arm {
            Arm::Random => return (self.drawn(start.number, coming), Shared::Drawn),
            Arm::Informed => Some(self.informed.clone()),
            Arm::Sequential if !first => {
                self.planner.shares(known, &self.knowledge.sizes(known), run, coming)
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
        let lengths = even_lengths(self.random_segments.min(samples).max(1), samples);
        let streams = Streams::new(self.knowledge.seed, &format!("random {samples}"));
        let maneuvers: Vec<usize> = self.planner.maneuvers().collect();
        random_segments(&streams, number, &maneuvers, &lengths)
    }

    /// The error after the run that the crude model expects, by which a one-shot trial is sized.
    fn expected(&self, arm: Arm, realization: &Realization) -> Option<f64> {
        if arm != Arm::OneShot {
            return None;
        }
        let Realization { known, run, .. } = realization;
        let errors = self.planner.standard_errors(known, &self.knowledge.sizes(known), run)?;
        Some(self.knowledge.relative(&errors, known))
    }

    /// Simulates all runs side by side and estimates from each; nothing where the nominal model diverges. All arms meet the
    /// same disturbances in a realization.
    fn found(&self, arm: Arm, all: &[Realization]) -> Result<Found, Refusal> {
        let bounded: Vec<bool> = all.iter().map(|realization| self.bounded(&realization.run)).collect();
        let mut kept: Vec<Run> = Vec::with_capacity(all.len());
        for (group, bounded) in all.chunks(LANES).zip(bounded.chunks(LANES)) {
            kept.extend(self.measured(arm, group)?.zip(bounded).filter(|(_, b)| **b).map(|(run, _)| run));
        }
        let mut found = self.estimators.estimates(&kept).map_err(refused)?.into_iter();
        Ok(bounded.iter().map(|b| b.then(|| found.next()).flatten()).collect())
    }

    /// The runs of up to [`LANES`] realizations as they were measured.
    fn measured<'r>(
        &'r self,
        arm: Arm,
        group: &'r [Realization],
    ) -> Result<impl Iterator<Item = Run> + 'r, Refusal> {
        let numbers: Vec<u32> = group.iter().map(|realization| realization.start.number).collect();
        let states = self.sea.simulate(&Group {
            design: arm.name(),
            streams: &Streams::new(self.knowledge.seed, "trial"),
            runs: &numbers,
            initial: group.iter().map(|realization| realization.run.initial).collect(),
            exogenous: group.iter().map(|realization| realization.run.exogenous.as_slice()).collect(),
        })?;
        Ok(group.iter().enumerate().map(move |(lane, realization)| {
            let [_, measured] = states.of(lane);
            realization.run.recorded(self.generator, arm.name(), numbers[lane], measured)
        }))
    }

    /// Whether instruments can be simulated: the nominal model stays bounded.
    fn bounded(&self, run: &GrowingRun) -> bool {
        let vessel = self.sea.vessel();
        let states = simulate_one(&vessel.model, &vessel.nominal, run.initial, &run.exogenous);
        check_diverged(states.into_iter()).is_none()
    }
}

/// The true parameters; errors are relative to them.
///
/// # Errors
/// A parameter without a true value, or of zero.
pub fn truth(vessel: &Vessel) -> Result<Vec<f64>, Invalid> {
    crate::moments::check_constants(&vessel.model)?;
    let truth = vessel.parameters(Source::Value)?;
    match vessel.model.parameter_names().zip(&truth).find(|(_, value)| **value == 0.0) {
        None => Ok(truth),
        Some((name, _)) => Err(Invalid::new(
            format!("parameter `{name}`, `value`"),
            "0",
            "a true parameter that is not zero, since errors are relative to it",
            "leave its term out",
        )),
    }
}

/// Samples by the end of each of `rounds` equally long rounds that `duration_s` is cut into.
///
/// # Errors
/// Rounds that are too short for an estimate; a trial that is too long.
pub fn ends(vessel: &Vessel, duration_s: f64, rounds: usize) -> Result<Vec<usize>, Invalid> {
    let samples = vessel.samples(duration_s);
    refuse_endless("`duration_s`", samples)?;
    let least = 2 * (vessel.model.parameters() + vessel.model.degrees.len());
    if samples / rounds < least {
        return Err(Invalid::new(
            "`rounds`",
            format!("{rounds} rounds of {samples} samples"),
            format!("at least {least} samples per round, twice the parameters and intercepts"),
            "take fewer, or lengthen `duration_s`",
        ));
    }
    Ok((1..=rounds).map(|round| round * samples / rounds).collect())
}

/// What is at fault where runs cannot be estimated.
fn refused(error: RunError) -> Refusal {
    match error {
        RunError::Diverged(_) => Refusal::Vessel(error.invalid()),
        RunError::TooShort { .. } => Refusal::Campaign(error.invalid()),
    }
}

fn unexcited() -> Invalid {
    let (found, expected) = ("maneuvers that do not excite every parameter", "a dictionary that does");
    Invalid::new("maneuvers", found, expected, "add a maneuver; see `design`")
}
