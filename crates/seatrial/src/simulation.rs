//! A whole simulation study in memory, from a vessel and its maneuvers to the scores of estimates.

use std::ops::Range;

use design::{Bounds, Criterion, Design, NoDesign, Options};
use estimation::predictor::InitialState;
use estimation::runs::{AdditionalUnknowns, RunError, RunEstimators};
use estimation::{EstimateStatus, EstimateView, Estimator, RunEstimate, RunScore, ValidationRuns};
use maneuver::{DictionaryFile, Generator};
use numerics::{GROUPS, LANES};
use plan::voyage::Shares;
use rayon::prelude::*;
use refusal::{Invalid, check_bounds};
use regression::runs::{Doing, NominalDiverged, RunInstruments, SharedInputs};
use regression::{InstrumentKind, MeanRemoval, Outcome};
use ship::engine::Run;
use ship::model::{Source, Vessel};
use study::campaign_file::CampaignFile;
use study::documents::DesignScores;
use study::scores::summarize;
use thiserror::Error;
use trial::campaign::{Campaign, Designed, Maneuvers, Refusal, SimulatedRun, Wanted};
use trial::moments::{Estimated, Moments, Pool, Prediction, Unpredictable, structure};

/// Why a study has no result.
#[derive(Clone, Debug, Error)]
pub enum StudyError {
    /// An invalid value.
    #[error(transparent)]
    Invalid(#[from] Invalid),
    /// A trial that cannot be simulated.
    #[error(transparent)]
    Trial(#[from] Refusal),
    /// Maneuvers that allow no design.
    #[error(transparent)]
    Design(#[from] NoDesign),
    /// Runs that cannot be estimated.
    #[error(transparent)]
    Estimate(#[from] RunError),
}

impl From<NominalDiverged> for StudyError {
    fn from(error: NominalDiverged) -> Self {
        Self::Estimate(error.into())
    }
}

impl From<Unpredictable> for StudyError {
    fn from(error: Unpredictable) -> Self {
        match error {
            Unpredictable::Maneuver(invalid) | Unpredictable::Vessel(invalid) => Self::Invalid(invalid),
        }
    }
}

/// A whole simulation study in memory: the information of the maneuvers, the design, disturbed realizations of it and
/// of random experiments, their estimates and scores. The programs do the same steps from file to file, with the same
/// numbers.
pub struct Study {
    vessel: Vessel,
    generator: Generator,
    campaign: CampaignFile,
}

/// Shares of the samples that are best for a criterion.
#[derive(Clone, Debug)]
pub struct Optimum {
    /// Names of the maneuvers, in the order of the shares.
    pub maneuvers: Vec<String>,
    /// The shares and their certificate.
    pub design: Design,
}

impl Study {
    /// The study of `campaign` with the maneuvers of `dictionary`.
    ///
    /// # Errors
    /// Invalid numbers; a maneuver with inputs from a table.
    pub fn new(
        vessel: Vessel,
        dictionary: &DictionaryFile,
        campaign: CampaignFile,
    ) -> Result<Self, StudyError> {
        check_bounds(&campaign)?;
        let generator = Generator::without_tables(&vessel, dictionary)?;
        Ok(Self { vessel, generator, campaign })
    }

    /// The vessel.
    pub fn vessel(&self) -> &Vessel {
        &self.vessel
    }

    /// The campaign's parameters.
    pub fn settings(&self) -> &CampaignFile {
        &self.campaign
    }

    /// Every maneuver of the dictionary on its own, undisturbed, except generated ones that exceed their limits.
    ///
    /// # Errors
    /// A maneuver that does not fit the model or that diverges.
    pub fn dictionary(&self) -> Result<Vec<Run>, StudyError> {
        undisturbed(&self.vessel, &self.generator, self.vessel.best_known(), "dictionary")
    }

    /// The information of each maneuver about the parameters: M = mean of φ̃ζ̃ᵀ per degree of freedom. `runs`: one
    /// per maneuver.
    ///
    /// # Errors
    /// A ship with forces; a nominal model that diverges; a maneuver that is too short.
    pub fn moments(&self, runs: &[Run]) -> Result<Moments, StudyError> {
        self.vessel.check_terms("moments")?;
        let model = &self.vessel.model;
        let (instruments, mut pool) = (InstrumentKind::Nominal, Pool::default());
        for (pooled, maneuver) in Prediction::new(&self.vessel, instruments, None, None).moments(runs)? {
            pool.add(pooled, maneuver)?;
        }
        Ok(Moments {
            vessel: self.vessel.name.clone(),
            sample_rate_hz: self.vessel.sample_rate_hz,
            instruments: Some(instruments),
            degrees: structure(model),
            maneuvers: pool.finish(model)?,
            held: Vec::new(),
            beyond: Vec::new(),
            disturbances: None,
            output_error: None,
            prior: None,
            sampled: None,
        })
    }

    /// The D-optimal shares for instrumental variables, with their certificate.
    ///
    /// # Errors
    /// Maneuvers that do not excite every parameter.
    pub fn design(&self, moments: &Moments) -> Result<Optimum, StudyError> {
        let dictionary = moments.dictionary(Estimated::Iv(MeanRemoval::Complete))?;
        let criterion = Criterion::Information(dictionary.information.clone());
        let design = criterion.solve(&Bounds::default(), &Options::default());
        let design = design.map_err(|e| dictionary.explain(e))?;
        Ok(Optimum { maneuvers: dictionary.maneuvers, design })
    }

    /// Disturbed realizations of the experiment that `designed` states, and of random ones.
    ///
    /// # Errors
    /// A design of other maneuvers; a maneuver that does not fit the model; a simulation that diverges.
    pub fn simulate(&self, designed: &Designed) -> Result<Vec<SimulatedRun>, StudyError> {
        let sea = self.campaign.sea(&self.vessel)?;
        let campaign = Campaign::new(sea, &self.generator, designed, &self.campaign.settings(None))?;
        Ok(campaign.simulate_all()?)
    }

    /// The parameters of every run.
    ///
    /// # Errors
    /// An estimator that takes no forces; a nominal model that diverges; a run that is too short.
    pub fn estimate(
        &self,
        runs: &[SimulatedRun],
        estimator: Estimator,
    ) -> Result<Vec<RunEstimate>, StudyError> {
        let runs: Vec<Run> = runs.iter().map(|simulated| simulated.run.clone()).collect();
        let estimators = RunEstimators {
            vessel: &self.vessel,
            estimators: vec![estimator],
            removal: MeanRemoval::Complete,
            initial: InitialState::Known,
            additional: AdditionalUnknowns::default(),
            levels: Some(self.campaign.levels(self.vessel.sample_rate_hz)),
        };
        let estimates: Vec<_> = runs.par_chunks(TOGETHER).map(|some| estimators.estimates(some)).collect();
        let estimates: Vec<Vec<RunEstimate>> = estimates.into_iter().collect::<Result<_, _>>()?;
        Ok(estimates.concat())
    }

    /// Parameter error of every estimate, and its model's error in free simulation of the campaign's validation maneuvers.
    ///
    /// # Errors
    /// Validation maneuvers that do not fit the model or that diverge; no validation maneuvers.
    pub fn score(&self, estimates: &[RunEstimate]) -> Result<Vec<RunScore>, StudyError> {
        let validation = Generator::without_tables(&self.vessel, &self.campaign.validation_dictionary())?;
        let runs = undisturbed(&self.vessel, &validation, Source::Value, "validation")?;
        let truth: Option<Vec<f64>> = self.vessel.value.iter().copied().collect();
        let Some(runs) = ValidationRuns::new(&self.vessel, runs) else { return Ok(Vec::new()) };
        let scores = estimates.par_chunks(TOGETHER).map(|some| runs.score(some, truth.as_deref()));
        Ok(scores.collect::<Vec<_>>().concat())
    }

    /// Statistics of the scores of each design: above all the shares of realizations below the campaign's bounds,
    /// with their intervals.
    pub fn worth(&self, scores: &[RunScore]) -> Vec<DesignScores> {
        summarize(scores, self.campaign.bounds())
    }
}

/// Runs that one thread estimates or scores together.
const TOGETHER: usize = 64;

impl Optimum {
    /// The experiment of this design.
    pub fn designed(&self) -> Designed {
        let shares = self.maneuvers.iter().cloned().zip(self.design.shares.iter().copied());
        Designed { shares: shares.collect(), order: None }
    }

    /// The same for a plan on a chart.
    pub fn shares(&self) -> Shares {
        let share = self.maneuvers.iter().cloned().zip(self.design.shares.iter().copied());
        Shares { order: self.maneuvers.clone(), share: share.collect() }
    }
}

/// The runs of all maneuvers of `generator`, each on its own, simulated with the parameters of `source`; `design` is their label.
///
/// # Errors
/// A maneuver that the model cannot hold or that diverges; limits that no generated maneuver keeps.
pub fn undisturbed(
    vessel: &Vessel,
    generator: &Generator,
    source: Source,
    design: &str,
) -> Result<Vec<Run>, StudyError> {
    let maneuvers = Maneuvers::new(vessel, generator, source, design)?;
    let (runs, tally) = maneuvers.simulate(0..maneuvers.count())?;
    tally.check().map_err(Refusal::Dictionary)?;
    Ok(runs.into_iter().map(|simulated| simulated.run).collect())
}

// Realizations of a campaign that are estimated and scored as soon as they are simulated.

/// Runs that are simulated, estimated and scored together.
const STREAMED_TOGETHER: usize = 8 * LANES;

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
        self.estimators.check().map_err(Invalid::from)?;
        let together = self.together(runs.len());
        let parts = parts_of(runs, together, |runs| self.some(design, runs, kept));
        parts.into_iter().try_fold(Realized::default(), |mut all, part| {
            let Realized { runs, estimates, scores } = part?;
            all.runs.extend(runs);
            all.estimates.extend(estimates);
            all.scores.extend(scores);
            Ok(all)
        })
    }

    /// The number of `runs` per task, so that every thread has some.
    fn together(&self, runs: usize) -> usize {
        let searching = |e: &Estimator| matches!(e, Estimator::OutputError | Estimator::PredictionError);
        let most =
            if self.estimators.estimators.iter().any(searching) { SEARCHED } else { STREAMED_TOGETHER };
        runs.div_ceil(rayon::current_num_threads()).next_multiple_of(LANES).clamp(STREAMED_TOGETHER, most)
    }

    fn some(&self, design: usize, runs: Range<usize>, kept: usize) -> Result<Realized, StudyError> {
        let wanted = if runs.start < kept { Wanted::Commands } else { Wanted::Truth };
        let simulated = self.campaign.simulate(design, runs, wanted)?.into_iter();
        let (runs, rest): (Vec<Run>, Vec<_>) = simulated.map(|s| (s.run, (s.states, s.commands))).unzip();
        let estimates = self.estimators.estimates(&runs)?;
        let scores = self.validation.score(&estimates, self.truth.as_deref());
        let again = runs.into_iter().zip(rest);
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
        self.estimators.check().map_err(Invalid::from)?;
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
        let scores = match alike.transpose() {
            Ok(alike) => parts_of(runs.clone(), STREAMED_TOGETHER, |runs| {
                self.scores_side_by_side(alike.as_ref(), design, runs)
            }),
            Err(diverged) => vec![Err(diverged.into())],
        };
        match scores.into_iter().collect::<Result<Vec<_>, _>>() {
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
                let groups = all.into_iter().map(|group| (group.starts(), group.side_by_side()));
                let nominal_side_by_side = instruments.nominal_side_by_side(groups, removal);
                let over =
                    |(i, at)| NominalDiverged::over(name, (before + i) as i32, at, vessel.sample_rate_hz);
                outcomes.extend(nominal_side_by_side.map_err(over)?);
                continue;
            };
            for group in all {
                outcomes.extend(alike.parameters(group.measured()).into_iter().take(group.runs()));
                group.recycle();
            }
        }
        let candidate = |i: usize| {
            let (run, outcome) = ((first + i) as i32, &outcomes[i]);
            let (status, parameters) = match outcome {
                Outcome::Identified(theta) => (EstimateStatus::Identified, Some(theta.as_slice())),
                Outcome::NotIdentifiable(_) => (EstimateStatus::NotIdentifiable, None),
                Outcome::TooShort => {
                    let samples = self.campaign.samples();
                    return Err(RunError::TooShort { design: name.to_owned(), run, samples });
                }
            };
            Ok(EstimateView { design: name, run, estimator: Estimator::Iv, status, parameters })
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
