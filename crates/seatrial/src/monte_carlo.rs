//! Realizations of a campaign that are estimated and scored as soon as they are simulated.

use std::ops::Range;

use estimation::runs::{RunError, RunEstimators};
use estimation::{
    EstimateStatus, EstimateView as Candidate, Estimator, RunEstimate, RunScore, ValidationRuns,
};
use numerics::{GROUPS, LANES};
use rayon::prelude::*;
use regression::runs::{Doing, NominalDiverged, RunInstruments, SharedInputs};
use regression::{InstrumentKind, Outcome};
use ship::engine::Run;
use trial::campaign::{Campaign, SimulatedRun, Wanted};

use crate::simulation::StudyError;

/// Runs that are simulated, estimated and scored together.
const TOGETHER: usize = 8 * LANES;

/// Maximum of the same for estimators that search: few searches take long, and those of many runs fill the lanes.
const SEARCHED: usize = 64 * LANES;

/// A campaign, the estimation of its runs and the validation of their models.
pub struct MonteCarlo<'a> {
    /// The runs.
    pub campaign: Campaign<'a>,
    /// The estimators of each run.
    pub estimators: RunEstimators<'a>,
    /// The validation runs.
    pub validation: ValidationRuns<'a>,
    /// The true parameters, if known.
    pub truth: Option<Vec<f64>>,
}

/// The results of some runs.
#[derive(Default)]
pub struct Realized {
    /// The runs to be kept.
    pub runs: Vec<SimulatedRun>,
    /// Their estimates, run by run by every estimator.
    pub estimates: Vec<RunEstimate>,
    /// The scores of these.
    pub scores: Vec<RunScore>,
}

impl Realized {
    /// A result with scores alone.
    pub fn scored(scores: Vec<RunScore>) -> Self {
        Self { scores, ..Self::default() }
    }
}

impl MonteCarlo<'_> {
    /// Number of groups of runs of one design that are simulated in lanes, all designs in order: the unit of
    /// sharding.
    pub fn groups(&self) -> usize {
        self.campaign.designs() * self.campaign.realizations().div_ceil(LANES)
    }

    /// The runs of `groups`, as ranges of at most `most` groups of one design each.
    pub fn parts(&self, groups: Range<usize>, most: usize) -> Vec<(usize, Range<usize>)> {
        let each = self.campaign.realizations().div_ceil(LANES);
        let (mut parts, mut first) = (Vec::new(), groups.start);
        while first < groups.end {
            let (design, within) = (first / each, first % each);
            let count = most.min(groups.end - first).min(each - within);
            let last = self.campaign.realizations().min((within + count) * LANES);
            parts.push((design, within * LANES..last));
            first += count;
        }
        parts
    }

    /// Simulates, estimates and scores `runs` of a design on all threads; the first `kept` runs of the design are kept.
    ///
    /// # Errors
    /// An estimator that takes no forces; a simulation that diverges; runs that are too short.
    pub fn realize(&self, design: usize, runs: Range<usize>, kept: usize) -> Result<Realized, StudyError> {
        self.estimators.check_forces()?;
        let together = self.together(runs.len());
        let found = parts_of(runs, together, |runs| self.some(design, runs, kept));
        found.into_iter().try_fold(Realized::default(), |mut all, found| {
            let Realized { runs, estimates, scores } = found?;
            all.runs.extend(runs);
            all.estimates.extend(estimates);
            all.scores.extend(scores);
            Ok(all)
        })
    }

    /// The number of `runs` per task, so that every thread has some.
    fn together(&self, runs: usize) -> usize {
        let searching = |e: &Estimator| matches!(e, Estimator::OutputError | Estimator::PredictionError);
        let most = if self.estimators.estimators.iter().any(searching) { SEARCHED } else { TOGETHER };
        runs.div_ceil(rayon::current_num_threads()).next_multiple_of(LANES).clamp(TOGETHER, most)
    }

    fn some(&self, design: usize, runs: Range<usize>, kept: usize) -> Result<Realized, StudyError> {
        let wanted = if runs.start < kept { Wanted::Commands } else { Wanted::Truth };
        let simulated = self.campaign.simulate(design, runs, wanted)?.into_iter();
        let (own, rest): (Vec<Run>, Vec<_>) = simulated.map(|s| (s.run, (s.states, s.commands))).unzip();
        let estimates = self.estimators.estimates(&own)?;
        let scores = self.validation.score(&estimates, self.truth.as_deref());
        let again = own.into_iter().zip(rest);
        let again = again.map(|(run, (states, commands))| SimulatedRun { run, states, commands });
        let kept = again.filter(|simulated| (simulated.run.run as usize) < kept).collect();
        Ok(Realized { runs: kept, estimates, scores })
    }

    /// Only the scores of [`Self::realize`]. If only instruments are requested, runs stay in lanes from their first
    /// sample to their score.
    ///
    /// # Errors
    /// See [`Self::realize`].
    pub fn scores(&self, design: usize, runs: Range<usize>) -> Result<Vec<RunScore>, StudyError> {
        self.estimators.check_forces()?;
        if self.estimators.estimators != [Estimator::Iv] {
            return Ok(self.realize(design, runs, 0)?.scores);
        }
        let RunEstimators { vessel, removal, .. } = self.estimators;
        let alike = self.campaign.experiment_of_all(design).map(|all| {
            let doing = Doing {
                design: self.campaign.names()[design],
                run: runs.start as i32,
                starts: all.segments.iter().map(|segment| segment.start).collect(),
                initial: all.initial,
                exogenous: &all.exogenous,
            };
            SharedInputs::new(vessel, &doing, removal)
        });
        let found = match alike.transpose() {
            Ok(alike) => parts_of(runs.clone(), TOGETHER, |runs| {
                self.scores_side_by_side(alike.as_ref(), design, runs)
            }),
            Err(diverged) => vec![Err(diverged.into())],
        };
        match found.into_iter().collect::<Result<Vec<_>, _>>() {
            // Such runs get instruments of their own, one by one.
            Err(StudyError::Estimate(RunError::Diverged(_))) => Ok(self.realize(design, runs, 0)?.scores),
            all => Ok(all?.concat()),
        }
    }

    fn scores_side_by_side(
        &self,
        alike: Option<&SharedInputs>,
        design: usize,
        runs: Range<usize>,
    ) -> Result<Vec<RunScore>, StudyError> {
        let RunEstimators { vessel, removal, .. } = self.estimators;
        let instruments = RunInstruments::new(vessel, InstrumentKind::Nominal);
        let (name, first) = (self.campaign.names()[design], runs.start);
        let mut outcomes = Vec::with_capacity(runs.len());
        for start in runs.clone().step_by(GROUPS * LANES) {
            let some = start..runs.end.min(start + GROUPS * LANES);
            let all = self.campaign.together(design, some, Wanted::Measured)?;
            let Some(alike) = alike else {
                let before = first + outcomes.len();
                let groups = all.into_iter().map(|own| (own.starts(), own.side_by_side()));
                let nominal_side_by_side = instruments.nominal_side_by_side(groups, removal);
                let over =
                    |(i, at)| NominalDiverged::over(name, (before + i) as i32, at, vessel.sample_rate_hz);
                outcomes.extend(nominal_side_by_side.map_err(over)?);
                continue;
            };
            for own in all {
                outcomes.extend(alike.parameters(own.measured()).into_iter().take(own.runs()));
                own.recycle();
            }
        }
        let candidate = |i: usize| {
            let (run, outcome) = ((first + i) as i32, &outcomes[i]);
            let (status, parameters) = match outcome {
                Outcome::Identified(own) => (EstimateStatus::Identified, Some(own.as_slice())),
                Outcome::NotIdentifiable(_) => (EstimateStatus::NotIdentifiable, None),
                Outcome::TooShort => {
                    let samples = self.campaign.samples();
                    return Err(RunError::TooShort { design: name.to_owned(), run, samples });
                }
            };
            Ok(Candidate { design: name, run, estimator: Estimator::Iv, status, parameters })
        };
        let candidates = (0..outcomes.len()).map(candidate).collect::<Result<Vec<_>, _>>()?;
        Ok(self.validation.scores(&candidates, self.truth.as_deref()))
    }
}

/// The results of `of` for `runs`, `together` at a time, on all threads; in their order.
fn parts_of<T: Send>(runs: Range<usize>, together: usize, of: impl Fn(Range<usize>) -> T + Sync) -> Vec<T> {
    let starts: Vec<usize> = runs.clone().step_by(together).collect();
    starts.into_par_iter().map(|start| of(start..runs.end.min(start + together))).collect()
}
