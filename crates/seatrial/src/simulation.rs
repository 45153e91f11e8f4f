//! A whole simulation study in memory, from a vessel and its maneuvers to the scores of estimates.

use design::{Bounds, Criterion, Design, NoDesign, Options};
use estimation::predictor::InitialState;
use estimation::runs::{AdditionalUnknowns, RunError, RunEstimators};
use estimation::{Estimator, RunEstimate, RunScore, ValidationRuns};
use maneuver::{DictionaryFile, Generator};
use plan::voyage::Shares;
use rayon::prelude::*;
use refusal::Invalid;
use regression::runs::{NominalDiverged, RunInstruments};
use regression::{InstrumentKind, MeanRemoval};
use ship::engine::Run;
use ship::model::{Source, Vessel};
use study::campaign_file::CampaignFile;
use study::documents::DesignScores;
use study::scores::summarize;
use thiserror::Error;
use trial::campaign::{Campaign, Designed, Maneuvers, Refusal, SimulatedRun};
use trial::moments::{Estimated, Moments, Pool, Prediction, structure};

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
        campaign.check()?;
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
        let prediction = Prediction::new(model, None, None);
        let (parts, mut pool) = (prediction.runs(runs), Pool::default());
        let instruments = InstrumentKind::Nominal;
        for batch in RunInstruments::new(&self.vessel, instruments).batches(&parts) {
            let (prepared, members) = batch?;
            for (pooled, maneuver) in prediction.moments(&prepared.batch(), members)? {
                pool.add(pooled, maneuver)?;
            }
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
        let found: Vec<_> = runs.par_chunks(TOGETHER).map(|some| estimators.estimates(some)).collect();
        let found: Vec<Vec<RunEstimate>> = found.into_iter().collect::<Result<_, _>>()?;
        Ok(found.concat())
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
