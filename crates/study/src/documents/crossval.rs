use artifact::Document;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use identification::crossval::{self, CrossValidation};
use identification::pooled::{NominalSource, Pool, SourceErrors};
use identification::{Estimator, MeanRemoval, ScoreStatus};

use super::trust::FreeRunErrors;

/// `crossval.json`: free simulation over runs or recordings that were left out of the estimate.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CrossvalDocument {
    /// How the instruments' mean is removed.
    pub mean_removal: MeanRemoval,
    /// Where the instruments' nominal model comes from.
    pub nominal: NominalSource,
    /// Strength of the pull towards it.
    pub prior: f64,
    /// Whether the estimated intercepts were simulated too.
    pub intercepts: bool,
    /// Length of the windows \[s\]; null: whole runs.
    pub window_s: Option<f64>,
    /// Number of windows that were simulated.
    pub windows: u64,
    /// Their samples.
    pub samples: u64,
    /// Number of folds.
    pub folds: u64,
    /// Standard deviations of the measured states over the windows.
    pub std_u: f64,
    /// Of sway speed.
    pub std_v: f64,
    /// Of yaw rate.
    pub std_r: f64,
    /// The estimator with the smallest norm of RMSE/std over all windows; null where none could be simulated.
    pub recommended: Option<Estimator>,
    /// That, and what went wrong, in words.
    pub statements: Vec<String>,
    /// One entry per estimator.
    pub estimators: Vec<EstimatorScore>,
}

/// One estimator over all folds.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct EstimatorScore {
    /// The estimator.
    pub name: Estimator,
    /// What became of its models.
    pub status: ScoreStatus,
    /// Why there are no errors.
    pub reason: Option<String>,
    /// Over all windows of all folds.
    pub errors: Option<FreeRunErrors>,
    /// Norm of RMSE/std.
    pub error_norm: Option<f64>,
    /// Windows that diverged.
    pub diverged: u64,
    /// Folds in which surge, sway, yaw were estimated with simulated instruments.
    pub by_instruments: [u64; 3],
    /// One entry per run or recording, when it was left out; against the standard deviations of its own states.
    pub sources: Vec<SourceScore>,
}

/// One estimator on one run or recording that was left out.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SourceScore {
    /// Its name.
    pub source: String,
    /// Windows of it.
    pub windows: u64,
    /// Windows that diverged.
    pub diverged: u64,
    /// Null where one diverged, there is no window, or no model.
    pub errors: Option<FreeRunErrors>,
}

impl CrossvalDocument {
    /// What was found with instruments from `nominal` over windows of `window_s` seconds.
    pub fn new(pool: &Pool, nominal: NominalSource, window_s: Option<f64>, found: &CrossValidation) -> Self {
        let [std_u, std_v, std_r] = found.std;
        Self {
            mean_removal: pool.removal,
            nominal,
            prior: pool.strength,
            intercepts: true,
            window_s,
            windows: found.windows,
            samples: found.samples,
            folds: found.folds as u64,
            std_u,
            std_v,
            std_r,
            recommended: found.recommended,
            statements: found.statements.clone(),
            estimators: found.scores.iter().map(EstimatorScore::from).collect(),
        }
    }
}

impl From<&crossval::EstimatorScore> for EstimatorScore {
    fn from(found: &crossval::EstimatorScore) -> Self {
        Self {
            name: found.estimator,
            status: found.status,
            reason: found.reason.clone(),
            errors: found.errors.as_ref().map(FreeRunErrors::from),
            error_norm: found.errors.and_then(|e| e.norm()),
            diverged: found.diverged,
            by_instruments: found.by_instruments,
            sources: found.sources.iter().map(SourceScore::from).collect(),
        }
    }
}

impl From<&SourceErrors> for SourceScore {
    fn from(found: &SourceErrors) -> Self {
        Self {
            source: found.source.clone(),
            windows: found.windows as u64,
            diverged: found.diverged,
            errors: found.errors.as_ref().map(FreeRunErrors::from),
        }
    }
}

impl Document for CrossvalDocument {
    const ID: &'static str = "crossval";
    const VERSION: u32 = 1;
    const UNITS: &'static [(&'static str, &'static str)] = &[
        ("prior", "1"),
        ("window_s", "s"),
        ("windows", "1"),
        ("samples", "1"),
        ("folds", "1"),
        ("std_u", "m/s"),
        ("std_v", "m/s"),
        ("std_r", "rad/s"),
        ("error_norm", "1"),
        ("diverged", "1"),
        ("by_instruments", "1"),
        ("rmse_u", "m/s"),
        ("rmse_v", "m/s"),
        ("rmse_r", "rad/s"),
        ("fit_u", "%"),
        ("fit_v", "%"),
        ("fit_r", "%"),
    ];
}
