use std::collections::BTreeMap;

use artifact::Document;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// `moments.json`: the lifted moment matrices of every maneuver.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MomentsDocument {
    /// Name of the vessel.
    pub vessel: String,
    /// Sampling rate \[Hz\].
    pub sample_rate_hz: f64,
    /// Where the instruments come from: `nominal simulation` or `regressors` (least squares).
    pub instruments: String,
    /// What each row and column of the matrices stands for.
    pub degrees: Vec<DegreeStructure>,
    /// One entry per maneuver, in the dictionary's order.
    pub maneuvers: Vec<ManeuverMoments>,
    /// What the matrices `B` were computed from, where there are any.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub disturbances: Option<ExpectedDisturbances>,
    /// What the matrices `F` and `P` of an output-error estimate are about, where there are any.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub output_error: Option<OutputErrorModel>,
}

/// The model whose free simulation the information of an output-error estimate is about.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct OutputErrorModel {
    /// Which parameters it has: `value`, `nominal`, or `value, draw 3` for one drawn around them.
    pub simulated_with: String,
    /// These parameters, in units of the state's increment per unit of the term.
    pub parameters: BTreeMap<String, f64>,
    /// Rows and columns of the matrices: the parameters of surge, `intercept (surge)`, then sway and yaw.
    pub rows: Vec<String>,
    /// Mean of SᵀS over the validation maneuvers, row-major, S = ∂x/∂θ̃ summed over the states: the variance of a free run's
    /// error is tr(cov G).
    #[serde(rename = "G", default, skip_serializing_if = "Option::is_none")]
    pub g: Option<Vec<f64>>,
}

/// What one maneuver tells an output-error estimate, per sample: matrices with `rows` of the model, row-major.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct OutputErrorMoments {
    /// Mean of SᵀWS, W the channels' weights 1/variance: Fisher's information where only white measurement errors disturb.
    #[serde(rename = "F")]
    pub f: Vec<f64>,
    /// What measurement errors add to the middle matrix of the covariance F⁻¹(E + P)F⁻¹/N; F where there is none.
    #[serde(rename = "E", default, skip_serializing_if = "Option::is_none")]
    pub e: Option<Vec<f64>>,
    /// What the current adds.
    #[serde(rename = "P", default, skip_serializing_if = "Option::is_none")]
    pub p: Option<Vec<f64>>,
}

/// The disturbances that an estimate's covariance is predicted from, white per sample.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ExpectedDisturbances {
    /// Standard deviation of the measured surge speed \[m/s\].
    pub std_u_m_s: f64,
    /// Standard deviation of the measured sway speed \[m/s\].
    pub std_v_m_s: f64,
    /// Standard deviation of the measured yaw rate \[rad/s\].
    pub std_r_rad_s: f64,
    /// Standard deviation of each component of the current in body axes \[m/s\].
    pub current_std_m_s: f64,
    /// Which parameters the residual was linearised with: `value` or `nominal`.
    pub linearised_at: String,
    /// These parameters, in units of the state's increment per unit of the term.
    pub parameters: BTreeMap<String, f64>,
    /// The nominal parameters, in the same units.
    pub nominal: BTreeMap<String, f64>,
}

/// One degree of freedom of the model structure.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DegreeStructure {
    /// `surge`, `sway` or `yaw`.
    pub name: String,
    /// Regressors φ in order, followed by the intercept `1`.
    pub regressors: Vec<String>,
    /// Parameters θ in order (one fewer than regressors).
    pub parameters: Vec<String>,
}

/// The moments of one maneuver.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ManeuverMoments {
    /// Name in the dictionary.
    pub name: String,
    /// Number of regression pairs N.
    pub samples: u64,
    /// One matrix per degree of freedom.
    pub degrees: Vec<DegreeMoments>,
    /// For an output-error estimate.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub output_error: Option<OutputErrorMoments>,
}

/// M = mean of φ̃ ζ̃ᵀ = [[X̄, Ȳ], [Z̄ᵀ, 1]] of one maneuver and degree of freedom.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DegreeMoments {
    /// `surge`, `sway` or `yaw`.
    pub name: String,
    /// Rows and columns of `M`.
    pub shape: [u64; 2],
    /// Row-major entries; row i belongs to regressor i, column j to instrument j.
    #[serde(rename = "M")]
    pub m: Vec<f64>,
    /// Largest change of an entry between the first and the second half of the maneuver, relative to the
    /// root mean squares of its regressor and instrument: 0 is stationary, 1 is not at all.
    pub nonstationarity: f64,
    /// Middle matrix of the estimate's covariance A⁻¹BA⁻ᵀ/N, A = Mᵀ: B = (1/N) Σ ζ̃ E[εε] ζ̃ᵀ, row-major, shape as `M`,
    /// rows and columns by instrument; in units of instrument i times instrument j times the state's variance.
    #[serde(rename = "B", default, skip_serializing_if = "Option::is_none")]
    pub b: Option<Vec<f64>>,
}

impl Document for MomentsDocument {
    const ID: &'static str = "moments";
    const VERSION: u32 = 1;
    const UNITS: &'static [(&'static str, &'static str)] = &[
        ("sample_rate_hz", "Hz"),
        ("samples", "1"),
        ("shape", "1"),
        ("M", "unit of regressor i times unit of instrument j"),
        ("nonstationarity", "1"),
    ];
}
