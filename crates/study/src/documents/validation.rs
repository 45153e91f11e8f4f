use estimation::{Estimator, PairedDifference, Quantiles};
use files::{Document, Units};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::Bounds;

/// `validation.json`: parameter and simulation errors of every design.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ValidationDocument {
    /// The bounds that the shares below are counted against.
    pub bounds: Bounds,
    /// Samples of the validation trajectory.
    pub samples: u64,
    /// Seed of the campaign that the runs come from; absent for runs that were not simulated.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub seed: Option<u64>,
    /// One entry per design.
    pub designs: Vec<DesignScores>,
    /// Which estimator to use for each design, where several were compared.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub recommendations: Option<Vec<EstimatorRecommendation>>,
    /// Every estimator on the same runs, where they were compared; `designs` then is that of `iv`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub compared: Option<Vec<EstimatorScores>>,
}

/// The errors of one estimator.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct EstimatorScores {
    /// The estimator.
    pub estimator: Estimator,
    /// One entry per design.
    pub designs: Vec<DesignScores>,
}

/// The errors of one design. A run without an estimate, or whose free simulation diverged, counts as above every bound
/// and as infinite in the quantiles (written null).
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DesignScores {
    /// Name of the design.
    pub design: String,
    /// Number of runs.
    pub runs: u64,
    /// Runs without an estimate.
    pub not_identifiable: u64,
    /// Runs whose search for an estimate ended nowhere; absent for estimators that search for none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub not_converged: Option<u64>,
    /// Runs whose free simulation diverged.
    pub diverged: u64,
    /// Share of all runs below the bound on the parameter error.
    pub parameter_error_share: f64,
    /// 95 % interval of that share (Wilson's); absent without runs.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub parameter_error_share_interval: Option<[f64; 2]>,
    /// Share of all runs below the bound on the simulation error.
    pub simulation_error_share: f64,
    /// 95 % interval of that share (Wilson's); absent without runs.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub simulation_error_share_interval: Option<[f64; 2]>,
    /// Share of all runs that have no estimate.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub without_estimate_share: Option<f64>,
    /// Of the parameter error.
    pub parameter_error: Quantiles,
    /// Of the simulation error.
    pub simulation_error: Quantiles,
    /// Of the RMSE in surge.
    pub rmse_u: Quantiles,
    /// Of the RMSE in sway.
    pub rmse_v: Quantiles,
    /// Of the RMSE in yaw rate.
    pub rmse_r: Quantiles,
}

/// Which estimator to use for one design.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct EstimatorRecommendation {
    /// Name of the design.
    pub design: String,
    /// The error that is compared, run by run.
    pub error: ComparedError,
    /// Number of runs.
    pub runs: u64,
    /// Estimators that leave a larger share of the runs without an estimate are not considered.
    pub most_without_estimate: f64,
    /// The estimator of least median error; null where the runs cannot tell it from another, or all are not considered.
    pub estimator: Option<Estimator>,
    /// The estimator of least median error, and those that the runs cannot tell from it.
    pub candidates: Vec<Estimator>,
    /// The other estimators that are considered, against that of least median error.
    pub others: Vec<PairedDifference>,
    /// That in words.
    pub statement: String,
}

/// What estimators are compared by.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum ComparedError {
    /// The parameter error.
    ParameterError,
    /// The simulation error, where the truth is not known.
    SimulationError,
}

impl Document for ValidationDocument {
    const ID: &'static str = "validation";
    const VERSION: u32 = 1;
    const UNITS: Units = &[
        ("1", "bounds.parameter_error samples runs not_identifiable not_converged diverged"),
        ("1", "parameter_error_share parameter_error_share_interval simulation_error_share_interval"),
        ("1", "without_estimate_share seed most_without_estimate simulation_error_share"),
        ("1", "parameter_error"),
        ("m/s, m/s and rad/s as numbers", "bounds.simulation_error simulation_error"),
        ("the compared error's unit", "others"),
        ("m/s", "rmse_u rmse_v"),
        ("rad/s", "rmse_r"),
    ];
}
