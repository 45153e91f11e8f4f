use std::sync::{Mutex, PoisonError};

use estimation::runs::{RunError, RunEstimators};
use estimation::{OutputInformation, RunEstimate, Simulated, parameter_error};
use maneuver::Generator;
use numerics::LANES;
use refusal::Invalid;
use regression::Noise;
use ship::engine::{Run, Streams, check_diverged, refuse_endless, simulate_one};
use ship::model::{Source, Vessel};

use super::planner::{GrowingRun, Knowledge, Planner, SoFar};
use super::{Arm, Outcome, Row, Shared};
use crate::campaign::{
    Group, Parts, Plan, Refusal, Sea, drawable, even_lengths, random_segments, shared_out,
};

/// The common data of all realizations.
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
    /// Whether what is commanded in any maneuver depends on the ship's motion.
    reacts: bool,
    /// Maneuvers that were realized for other realizations.
    parts: Mutex<Parts>,
}

/// A realization before its trial.
struct DrawnShip {
    number: u32,
    crude: Vec<f64>,
    /// The design from the crude model, for the one-shot trial and the first round.
    shares: Option<Vec<f64>>,
}

/// The estimates of realizations; `None` where the nominal model diverges.
type Estimates = Vec<Option<RunEstimate>>;

/// A realization in the trial of an arm.
struct Realization<'a> {
    arm: Arm,
    start: &'a DrawnShip,
    /// Parameters of the planning model.
    known: Vec<f64>,
    /// Shares of the latest plan.
    shares: Vec<f64>,
    run: GrowingRun,
    /// The run as it was last recorded.
    recorded: Option<Run>,
    /// The latest estimate.
    latest: Option<Vec<f64>>,
}

impl<'a> Trial<'a> {
    /// `noise`: the levels that designs and expected errors are predicted from; `estimators`: the estimator of the runs;
    /// `ends`: samples by the end of every round; `random_segments`: segments of a random experiment.
    ///
    /// # Errors
    /// A vessel without true parameters that errors can be relative to; maneuvers that the model cannot hold,
    /// or that do not excite every parameter.
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
        if planner.maneuvers().all(|q| generator.tables().contains_key(&q)) {
            return Err(Refusal::Dictionary(tables_alone()));
        }
        let informed = planner
            .shares(&truth, &knowledge.sizes(&truth), None, ends[0])
            .ok_or_else(|| Refusal::Dictionary(unexcited()))?;
        let parts = Mutex::default();
        Ok(Self {
            sea,
            generator,
            planner,
            estimators,
            knowledge,
            truth,
            informed,
            ends,
            random_segments,
            reacts: (0..generator.maneuvers().len()).any(|index| generator.reacts(index)),
            parts,
        })
    }

    /// Samples by the end of every round.
    pub fn ends(&self) -> &[usize] {
        &self.ends
    }

    /// Number of maneuvers to design with.
    pub fn maneuvers(&self) -> usize {
        self.planner.maneuvers().len()
    }

    /// A statement about maneuvers with tables of inputs, if there are any.
    pub fn statement(&self) -> Option<String> {
        let names: Vec<&str> = self.generator.tables().values().map(|one| one.maneuver.as_str()).collect();
        (!names.is_empty()).then(|| {
            format!(
                "tables of inputs ({}) are played whole: their shares of a round are rounded to plays, and random trials go \
                 without those of another length than a segment",
                names.join(", ")
            )
        })
    }

    /// The rows of realizations `numbers`, which are estimated in lanes: realizations, arms, rounds in order.
    ///
    /// # Errors
    /// A maneuver that the model cannot hold; a true vessel that diverges; a run too short for its unknowns.
    pub fn realizations(&self, numbers: std::ops::Range<u32>) -> Result<Vec<Row>, Refusal> {
        let starts: Vec<DrawnShip> = numbers.map(|number| self.start(number)).collect();
        let begin = |arm| starts.iter().map(move |start| self.begin(arm, start)).collect();
        let mut arms: Vec<Vec<Realization>> = Arm::ALL.into_iter().map(begin).collect();
        let mut rows = Vec::with_capacity(starts.len() * Arm::ALL.len() * self.ends.len());
        let mut parts = self.parts.lock().unwrap_or_else(PoisonError::into_inner).clone();
        for round in 0..self.ends.len() {
            rows.extend(self.round(round, &mut arms, &mut parts)?);
        }
        self.parts.lock().unwrap_or_else(PoisonError::into_inner).take(parts);
        rows.sort_by_key(|row| (row.realization, row.arm as usize, row.round));
        Ok(rows)
    }

    fn start(&self, number: u32) -> DrawnShip {
        let crude = self.knowledge.crude(number);
        let sizes = self.knowledge.sizes(&crude);
        let shares = self.planner.shares(&crude, &sizes, None, self.ends[0]);
        DrawnShip { number, crude, shares }
    }

    fn begin<'s>(&self, arm: Arm, start: &'s DrawnShip) -> Realization<'s> {
        let known = if arm == Arm::Informed { self.truth.clone() } else { start.crude.clone() };
        let run = GrowingRun::default();
        Realization { arm, start, known, shares: Vec::new(), run, recorded: None, latest: None }
    }

    /// A round of all arms: plan, run, estimate, learn.
    fn round(&self, n: usize, arms: &mut [Vec<Realization>], parts: &mut Parts) -> Result<Vec<Row>, Refusal> {
        let samples = self.ends[n];
        let information = self.information(&arms[Arm::Sequential as usize]);
        let information = information.iter().map(Option::as_ref).chain(std::iter::repeat(None));
        let each = arms.iter_mut().flatten().zip(information);
        let shared = each.map(|(trial, information)| self.extend(trial, information, parts, samples));
        let shared: Vec<Shared> = shared.collect::<Result<_, _>>()?;
        let expected = self.expected(&arms[Arm::OneShot as usize]);
        self.sail(n, arms)?;
        let estimates = self.estimated(n, arms)?;
        let row = |((realization, run), shared): ((&mut Realization, Option<RunEstimate>), _)| {
            let estimate = run.as_ref().and_then(|run| run.estimate.as_ref());
            let predicted = estimate.map(|(t, errors)| self.learn(realization, t, errors));
            realization.latest = estimate.map(|(theta, _)| theta.clone()).or(realization.latest.take());
            Row {
                arm: realization.arm,
                realization: realization.start.number,
                round: n as u32,
                samples,
                shared,
                outcome: run.as_ref().map_or(Outcome::Diverged, |run| run.status.into()),
                parameter_error: estimate.map(|(t, _)| parameter_error(t, &self.truth)),
                predicted_error: predicted.filter(|error| !error.is_nan()),
                expected_error: None,
            }
        };
        let mut rows: Vec<Row> = arms.iter_mut().flatten().zip(estimates).zip(shared).map(row).collect();
        let one_shot = rows.iter_mut().filter(|row| row.arm == Arm::OneShot);
        one_shot.zip(expected).for_each(|(row, expected)| row.expected_error = expected);
        Ok(rows)
    }

    /// The estimates at the end of a round, arm by arm.
    fn estimated(&self, round: usize, arms: &[Vec<Realization>]) -> Result<Estimates, Refusal> {
        let new = Arm::ALL.into_iter().filter(|arm| !repeats(round, *arm));
        let mut fresh = self.estimates_of(round, new.map(|arm| arms[arm as usize].as_slice()))?.into_iter();
        let mut all: Vec<Estimates> = Vec::with_capacity(arms.len());
        for (arm, realizations) in Arm::ALL.into_iter().zip(arms) {
            all.push(match repeats(round, arm) {
                true => all[Arm::Sequential as usize].clone(),
                false => fresh.by_ref().take(realizations.len()).collect(),
            });
        }
        Ok(all.into_iter().flatten().collect())
    }

    /// The information of `realizations` so far, by their planning models; `None` before the first round.
    fn information(&self, realizations: &[Realization]) -> Vec<Option<OutputInformation>> {
        let begun = realizations.iter().filter(|realization| !realization.run.exogenous.is_empty());
        let runs = begun.map(|begun| Simulated {
            theta: &begun.known,
            initial: begun.run.initial,
            exogenous: &begun.run.exogenous,
        });
        self.planner.informations(&runs.collect::<Vec<_>>())
    }

    /// Plans the time until `end`, given the information of the run. The sequential trial is one growing run;
    /// the others are planned for their total time.
    fn extend(
        &self,
        realization: &mut Realization,
        information: Option<&OutputInformation>,
        parts: &mut Parts,
        end: usize,
    ) -> Result<Shared, Refusal> {
        let vessel = self.sea.vessel();
        if realization.arm != Arm::Sequential {
            realization.run = GrowingRun::default();
        }
        let coming = end - realization.run.samples(vessel);
        let (plan, shared) = self.plan(realization, information, coming);
        let went = realization.run.extend(vessel, self.generator, parts, &plan);
        went.map_err(Refusal::Dictionary)?;
        Ok(shared)
    }

    /// The predicted error of an estimate; the next round is planned with the updated model.
    fn learn(&self, realization: &mut Realization, theta: &[f64], standard_errors: &[f64]) -> f64 {
        let learnt = self.knowledge.learnt(&realization.start.crude, theta, standard_errors);
        let promised = self.knowledge.relative(standard_errors, &learnt);
        if realization.arm == Arm::Sequential {
            realization.known = learnt;
        }
        promised
    }

    /// The plan of the coming samples, and how it was chosen.
    fn plan(
        &self,
        realization: &mut Realization,
        information: Option<&OutputInformation>,
        coming: usize,
    ) -> (Plan, Shared) {
        let Realization { arm, start, known, shares, run, .. } = realization;
        let designed = match arm {
            Arm::Random => return (self.drawn(start.number, coming), Shared::Drawn),
            Arm::Informed => Some(self.informed.clone()),
            Arm::Sequential if !run.exogenous.is_empty() => {
                let samples = run.samples(self.sea.vessel());
                let so_far = information.map(|information| SoFar { samples, information, shares });
                let sizes = self.knowledge.sizes(known);
                so_far.and_then(|so_far| self.planner.shares(known, &sizes, Some(so_far), coming))
            }
            Arm::Sequential | Arm::OneShot => start.shares.clone(),
        };
        let shared = if designed.is_some() { Shared::Designed } else { Shared::Even };
        let maneuvers = self.planner.maneuvers();
        *shares = designed.unwrap_or_else(|| vec![1.0 / maneuvers.len() as f64; maneuvers.len()]);
        (self.shared_out(&maneuvers.collect::<Vec<_>>(), shares, coming), shared)
    }

    /// `coming` samples by the shares of `maneuvers`. The rest after whole plays of tables is divided among
    /// the others, evenly if none of them has a share.
    fn shared_out(&self, maneuvers: &[usize], shares: &[f64], coming: usize) -> Plan {
        let (tables, count) = (self.generator.tables(), self.generator.maneuvers().len());
        let mut all = vec![0.0; count];
        maneuvers.iter().zip(shares).for_each(|(q, share)| all[*q] = *share);
        shared_out(&all, tables, coming).unwrap_or_else(|_| {
            let others = maneuvers.iter().filter(|q| !tables.contains_key(q));
            others.for_each(|q| all[*q] = 1e-9);
            shared_out(&all, tables, coming).unwrap_or_default()
        })
    }

    /// Equally long segments, each any maneuver; tables of another length are left out.
    fn drawn(&self, number: u32, samples: usize) -> Plan {
        let lengths = even_lengths(self.random_segments.min(samples).max(1), samples);
        let streams = Streams::new(self.knowledge.seed, &format!("random {samples}"));
        let maneuvers =
            drawable(&self.planner.maneuvers().collect::<Vec<_>>(), self.generator.tables(), &lengths);
        random_segments(&streams, number, &maneuvers, &lengths)
    }

    /// The errors after the runs that crude models predict, by which one-shot trials are sized.
    fn expected(&self, one_shot: &[Realization]) -> Vec<Option<f64>> {
        let expected = |(realization, information): (&Realization, Option<OutputInformation>)| {
            let samples = realization.run.samples(self.sea.vessel());
            let sizes = self.knowledge.sizes(&realization.known);
            let errors = self.planner.standard_errors(&information?, &sizes, samples)?;
            Some(self.knowledge.relative(&errors, &realization.known))
        };
        one_shot.iter().zip(self.information(one_shot)).map(expected).collect()
    }

    /// Simulates the runs of `arms` in lanes. All arms have the same disturbances in a realization.
    fn sail(&self, round: usize, arms: &mut [Vec<Realization>]) -> Result<(), Refusal> {
        let active = Arm::ALL.into_iter().zip(arms).filter(|(arm, _)| !repeats(round, *arm));
        active.flat_map(|(_, all)| all.chunks_mut(LANES)).try_for_each(|group| self.measure(group))
    }

    /// Estimates from the runs of `arms`, arm by arm; `None` where the nominal model diverges.
    fn estimates_of<'r>(
        &self,
        round: usize,
        arms: impl Iterator<Item = &'r [Realization<'r>]>,
    ) -> Result<Estimates, Refusal> {
        let (mut kept, mut near, mut bounded) = (Vec::new(), Vec::new(), Vec::new());
        for realization in arms.flatten() {
            let run = realization.recorded.as_ref().filter(|run| self.bounded(run));
            bounded.push(run.is_some());
            if let Some(run) = run {
                kept.push(run.clone());
                near.push(realization.latest.clone());
            }
        }
        // After the first round the search starts from the previous estimates.
        let near = (round > 0).then_some(near.as_slice());
        let mut estimates = self.estimators.estimates_from(&kept, near).map_err(refused)?.into_iter();
        Ok(bounded.into_iter().map(|b| b.then(|| estimates.next()).flatten()).collect())
    }

    /// Runs up to [`LANES`] realizations of an arm.
    fn measure(&self, group: &mut [Realization]) -> Result<(), Refusal> {
        let numbers: Vec<u32> = group.iter().map(|realization| realization.start.number).collect();
        let design = group.first().map_or("", |realization| realization.arm.name());
        let states = self.sea.simulate(&Group {
            design,
            streams: &Streams::new(self.knowledge.seed, "trial"),
            runs: &numbers,
            initial: group.iter().map(|realization| realization.run.initial).collect(),
            exogenous: group.iter().map(|realization| realization.run.exogenous.as_slice()).collect(),
            helms: group.iter().filter(|_| self.reacts).map(|realization| realization.run.helm()).collect(),
        })?;
        for (lane, realization) in group.iter_mut().enumerate() {
            let ([_, measured], run) = (states.of(lane), &mut realization.run);
            if let Some(exogenous) = states.exogenous_of(lane).filter(|_| self.reacts) {
                run.exogenous = exogenous;
            }
            let recorded = run.recorded(self.sea.vessel(), self.generator, design, numbers[lane], measured);
            realization.recorded = Some(recorded);
        }
        Ok(())
    }

    /// Whether instruments can be simulated: the nominal model stays bounded.
    fn bounded(&self, run: &Run) -> bool {
        let vessel = self.sea.vessel();
        let exogenous = run.view().instrument_exogenous;
        let states = simulate_one(&vessel.model, &vessel.nominal, run.initial, exogenous);
        check_diverged(states.into_iter()).is_none()
    }
}

/// Whether an arm is the same as another one: in the first round, one that begins with the crude model.
fn repeats(round: usize, arm: Arm) -> bool {
    round == 0 && arm == Arm::OneShot
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

/// Samples by the end of each of `rounds` equally long rounds of a trial of `duration_s`.
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

/// The refusal of runs that cannot be estimated.
fn refused(error: RunError) -> Refusal {
    match error {
        RunError::Diverged(_) | RunError::Forces(_) => Refusal::Vessel(error.invalid()),
        RunError::TooShort { .. } => Refusal::Campaign(error.invalid()),
    }
}

/// Rounds must be filled completely, which whole plays of tables cannot do.
fn tables_alone() -> Invalid {
    let expected = "at least one that is generated, for what whole plays of tables leave of a round";
    Invalid::new("maneuvers", "tables of inputs alone", expected, "add a maneuver")
}

fn unexcited() -> Invalid {
    let (which, expected) = ("maneuvers that do not excite every parameter", "a dictionary that does");
    Invalid::new("maneuvers", which, expected, "add a maneuver; see `design`")
}
