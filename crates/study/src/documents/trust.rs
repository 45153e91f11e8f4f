use estimation::Estimator;
use estimation::criticism::Criticism;
use estimation::pooled::{Added, DegreeTrust, Pool, Pooled, SourceErrors};
use files::{Document, Units};
use regression::MeanRemoval;
use regression::pooled::NominalSource;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::ConstrainedParameter;

/// `trust.json`: how far one pooled estimate can be trusted.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TrustDocument {
    /// The estimator.
    pub estimator: Estimator,
    /// How the instruments' mean is removed.
    pub mean_removal: MeanRemoval,
    /// Where the instruments' nominal model comes from.
    pub nominal: NominalSource,
    /// Strength of the pull towards the nominal model.
    pub prior: f64,
    /// Number of sub-experiments.
    pub parts: u64,
    /// Number of runs or recordings they were cut from.
    pub sources: u64,
    /// Regression pairs.
    pub samples: u64,
    /// Lags of Bartlett's weights in the standard errors.
    pub bandwidth: u64,
    /// Resamples of the bootstrap over sub-experiments.
    pub replicates: u64,
    /// What to know before using the estimate, in words.
    pub statements: Vec<String>,
    /// Surge, sway, yaw.
    pub degrees: Vec<DegreeTrust>,
    /// Parameters that are fixed or tied to others.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub constrained: Vec<ConstrainedParameter>,
    /// Free simulation over every run or recording.
    pub runs: Vec<SourceErrors>,
    /// What the model lacks; absent where the model diverges or has no estimate.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub criticism: Option<Criticism>,
    /// Terms that the model was found to lack and was given, in that order; absent where none were.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub added: Vec<Added>,
}

impl TrustDocument {
    /// The diagnostics of `found`, which `estimator` found from `pool` with instruments from `nominal`.
    pub fn new(
        pool: &Pool,
        nominal: NominalSource,
        estimator: Estimator,
        replicates: u32,
        found: &Pooled,
        added: &[Added],
    ) -> Self {
        Self {
            estimator,
            mean_removal: pool.removal,
            nominal,
            prior: pool.strength,
            parts: found.parts as u64,
            sources: found.sources.len() as u64,
            samples: found.samples,
            bandwidth: found.bandwidth as u64,
            replicates: u64::from(replicates),
            statements: found.statements.clone(),
            degrees: found.degrees.clone(),
            constrained: ConstrainedParameter::all(pool.vessel, Some(found)),
            runs: found.sources.clone(),
            criticism: found.criticism.clone(),
            added: added.to_vec(),
        }
    }
}

impl Document for TrustDocument {
    const ID: &'static str = "trust";
    const VERSION: u32 = 1;
    const UNITS: Units = &[
        ("1", "prior parts sources samples bandwidth replicates condition condition_index variation"),
        ("1", "instrument_strength correlation statistic lags p_value first_autocorrelation strongest"),
        ("1", "diverged error_ratio evidence factor below turns"),
        ("the unit beside it", "value visible_from std"),
        ("the parameter's unit", "estimate standard_error bootstrap_std bootstrap_low bootstrap_high"),
        ("samples", "lag"),
        ("%", "instrument_fit fit_u fit_v fit_r"),
        ("m/s", "rmse_u rmse_v noise_u noise_v current_std"),
        ("rad/s", "rmse_r noise_r"),
        ("s", "current_time_s time_s"),
    ];
}
