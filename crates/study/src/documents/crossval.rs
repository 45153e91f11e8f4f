use files::{Document, Units};
use regression::MeanRemoval;
use regression::pooled::NominalSource;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use estimation::pooled::Pool;
use estimation::{Estimator, PairedDifference, Recommendation};
use validation::crossval::{CrossValidation, EstimatorScore};

/// `crossval.json`: free simulation over runs or recordings that were left out of the estimate.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CrossvalDocument {
    /// How the instruments' mean is removed.
    pub mean_removal: MeanRemoval,
    /// Where the instruments' nominal model comes from.
    pub nominal: NominalSource,
    /// Strength of the pull towards it; of forces the weight of their priors.
    pub prior: f64,
    /// Whether forces were fitted, which have no instruments.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub forces: bool,
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
    /// The estimator with the least median norm of RMSE/std over the recordings; null where they cannot tell it from another,
    /// or none could be simulated over all.
    pub recommended: Option<Estimator>,
    /// That of least median norm, and those that the recordings cannot tell from it.
    pub candidates: Vec<Estimator>,
    /// The other estimators against that of least median norm, recording by recording.
    pub differences: Vec<PairedDifference>,
    /// That, and what went wrong, in words.
    pub statements: Vec<String>,
    /// One entry per estimator.
    pub estimators: Vec<EstimatorScore>,
}

impl CrossvalDocument {
    /// The result with instruments from `nominal` over windows of `window_s` seconds.
    pub fn new(pool: &Pool, nominal: NominalSource, window_s: Option<f64>, found: &CrossValidation) -> Self {
        let Pool { removal, strength, .. } = *pool;
        Self { mean_removal: removal, nominal, prior: strength, ..Self::of(window_s, found) }
    }

    /// The result of a ship with forces, fitted with priors of `prior_weight`.
    pub fn of_forces(prior_weight: f64, window_s: Option<f64>, found: &CrossValidation) -> Self {
        Self { forces: true, intercepts: false, prior: prior_weight, ..Self::of(window_s, found) }
    }

    fn of(window_s: Option<f64>, found: &CrossValidation) -> Self {
        let [std_u, std_v, std_r] = found.std;
        Self {
            mean_removal: MeanRemoval::None,
            nominal: NominalSource::Given,
            prior: 0.0,
            forces: false,
            intercepts: true,
            window_s,
            windows: found.windows,
            samples: found.samples,
            folds: found.folds as u64,
            std_u,
            std_v,
            std_r,
            recommended: found.recommendation.as_ref().and_then(Recommendation::estimator),
            candidates: found.recommendation.as_ref().map_or(Vec::new(), Recommendation::candidates),
            differences: found.recommendation.iter().flat_map(|r| &r.others).map(Into::into).collect(),
            statements: found.statements.clone(),
            estimators: found.scores.clone(),
        }
    }

    /// How far an estimator's errors lie above the least.
    pub fn difference(&self, estimator: Estimator) -> Option<&PairedDifference> {
        self.differences.iter().find(|other| other.estimator == estimator)
    }
}

impl Document for CrossvalDocument {
    const ID: &'static str = "crossval";
    const VERSION: u32 = 1;
    const UNITS: Units = &[
        ("1", "prior windows samples folds error_norm diverged by_instruments differences"),
        ("s", "window_s"),
        ("m/s", "std_u std_v rmse_u rmse_v"),
        ("rad/s", "std_r rmse_r"),
        ("%", "fit_u fit_v fit_r"),
    ];
}
