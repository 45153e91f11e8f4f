use thiserror::Error;
use vessel::RunView;

use super::statements::statements;
use super::trust::Judge;
use super::{
    DegreeTrust, Delivered, Estimated, Judgement, LostInstruments, Part, Pool, PooledRuns, SourceErrors,
};
use crate::criticism::{Criticism, Subject, criticise};
use crate::{EstimateStatus, Estimator, RunEstimate};

/// One estimate from all runs, and how far it can be trusted.
#[derive(Clone, Debug, PartialEq)]
pub struct Pooled {
    /// Name of the design of the first run.
    pub design: String,
    /// Number of parts.
    pub parts: usize,
    /// Regression pairs.
    pub samples: u64,
    /// Lags of Bartlett's weights in the standard errors.
    pub bandwidth: usize,
    /// Surge, sway, yaw.
    pub degrees: Vec<DegreeTrust>,
    /// Free simulation over every run or recording.
    pub sources: Vec<SourceErrors>,
    /// What to know before using the estimate, in words.
    pub statements: Vec<String>,
    /// The whole model; none unless all degrees of freedom have an estimate.
    pub delivered: Option<Delivered>,
    /// What the model lacks; none where it diverges or has no estimate.
    pub criticism: Option<Criticism>,
}

impl Pooled {
    /// The estimate as that of one run; none unless all degrees of freedom have one.
    pub fn as_run(&self, estimator: Estimator) -> RunEstimate {
        let parameters = || self.degrees.iter().flat_map(|d| &d.parameters);
        let theta: Option<Vec<f64>> = parameters().map(|p| p.estimate).collect();
        let errors: Option<Vec<f64>> = parameters().map(|p| p.standard_error).collect();
        let estimate = theta.zip(errors);
        let identified = estimate.is_some();
        RunEstimate {
            design: self.design.clone(),
            run: 0,
            estimator,
            status: if identified { EstimateStatus::Identified } else { EstimateStatus::NotIdentifiable },
            estimate,
            condition: [0, 1, 2].map(|d: usize| self.degrees[d].condition.unwrap_or(f64::INFINITY)),
            weakest: [0, 1, 2].map(|d: usize| self.degrees[d].weakest_parameter().to_owned()),
        }
    }
}

/// Why there is no pooled estimate.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum PoolError {
    /// No instruments could be simulated.
    #[error(transparent)]
    Lost(#[from] LostInstruments),
    /// No degree of freedom is identifiable, for these reasons.
    #[error("no degree of freedom is identifiable ({})", .0.join("; "))]
    NotIdentifiable(Vec<String>),
}

/// Estimates from all of `runs` and judges the estimate. `resampled` is called with the number of resamples that are done
/// where each takes long.
///
/// # Errors
/// No instruments; no degree of freedom that is identifiable.
pub fn estimate(
    pool: &Pool,
    runs: &PooledRuns,
    estimator: Estimator,
    judgement: &Judgement,
    resampled: &(dyn Fn(usize) + Sync),
) -> Result<Pooled, PoolError> {
    let mut parts: Vec<Part> = runs.parts(pool.part_samples);
    let found = pool.estimate(&mut parts, estimator)?;
    if found.degrees.iter().all(|d| d.solution.is_none()) {
        return Err(PoolError::NotIdentifiable(pool.unidentified(&found.degrees)));
    }
    let judge = Judge { pool, found: &found, parts: &parts, judgement, resampled };
    let degrees = judge.degrees();
    let sources = judge.sources(runs);
    let lost = found.diverged.as_ref().map(LostInstruments::to_string);
    let criticism = criticism(pool, &found, runs);
    let criticised = criticism.iter().flat_map(|found| &found.statements).cloned();
    Ok(Pooled {
        design: runs.design().to_owned(),
        parts: parts.len(),
        samples: parts.iter().map(|p| p.samples() as u64).sum(),
        bandwidth: judge.bandwidth(),
        statements: lost.into_iter().chain(criticised).chain(statements(&degrees)).collect(),
        delivered: Delivered::new(pool, &found, &parts, &degrees, &sources),
        degrees,
        sources,
        criticism,
    })
}

/// Most samples that are looked at for what the model lacks.
const MOST_CRITICISED: usize = 300_000;

/// What the model lacks, by the first recordings up to [`MOST_CRITICISED`] samples, whole ones.
fn criticism(pool: &Pool, found: &Estimated, runs: &PooledRuns) -> Option<Criticism> {
    let parameters = found.parameters(&pool.model)?;
    let mut samples = 0;
    let recordings: Vec<Part> = runs
        .windows(None)
        .flat_map(|(_, whole)| whole)
        .take_while(|recording| {
            samples += recording.samples();
            samples <= MOST_CRITICISED
        })
        .collect();
    let views: Vec<RunView> = recordings.iter().map(Part::view).collect();
    criticise(&Subject {
        model: &pool.model,
        parameters: &parameters,
        runs: &views,
        rate_hz: pool.vessel.sample_rate_hz,
        known_start: false,
        levels: None,
    })
}
