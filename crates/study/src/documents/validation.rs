use artifact::Document;
use identification::Estimator;
use numerics::statistics::{quantile, sorted};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// `validation.json`: parameter and simulation errors of every design.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ValidationDocument {
    /// The bounds that the shares below are counted against.
    pub bounds: Bounds,
    /// Samples of the validation trajectory.
    pub samples: u64,
    /// One entry per design.
    pub designs: Vec<DesignScores>,
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

/// Bounds under which an estimate counts as good.
#[derive(Clone, Copy, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Bounds {
    /// On the parameter error: the 2-norm over the parameters of (θ̂ − θ)/θ.
    pub parameter_error: f64,
    /// On the simulation error: the 2-norm of the RMSE in surge, sway and yaw.
    pub simulation_error: f64,
}

/// The errors of one design. A run without an estimate, or whose free simulation diverged, counts as above every bound
/// and as infinite in the quantiles (written null).
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
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
    /// Share of all runs below the bound on the simulation error.
    pub simulation_error_share: f64,
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

/// Quantiles over the runs; null where the quantile falls among runs without a value.
#[derive(Clone, Copy, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Quantiles {
    /// 10 %.
    pub q10: Option<f64>,
    /// 50 %.
    pub median: Option<f64>,
    /// 90 %.
    pub q90: Option<f64>,
    /// 99 %.
    pub q99: Option<f64>,
    /// The largest.
    pub max: Option<f64>,
}

impl Quantiles {
    /// Quantiles of values, absent ones counted as infinite.
    pub fn of(values: impl Iterator<Item = Option<f64>>) -> Self {
        let sorted = sorted(values);
        Self {
            q10: quantile(&sorted, 0.1),
            median: quantile(&sorted, 0.5),
            q90: quantile(&sorted, 0.9),
            q99: quantile(&sorted, 0.99),
            max: quantile(&sorted, 1.0),
        }
    }
}

impl Document for ValidationDocument {
    const ID: &'static str = "validation";
    const VERSION: u32 = 1;
    const UNITS: &'static [(&'static str, &'static str)] = &[
        ("bounds.parameter_error", "1"),
        ("bounds.simulation_error", "m/s, m/s and rad/s as numbers"),
        ("samples", "1"),
        ("runs", "1"),
        ("not_identifiable", "1"),
        ("not_converged", "1"),
        ("diverged", "1"),
        ("parameter_error_share", "1"),
        ("simulation_error_share", "1"),
        ("parameter_error", "1"),
        ("simulation_error", "m/s, m/s and rad/s as numbers"),
        ("rmse_u", "m/s"),
        ("rmse_v", "m/s"),
        ("rmse_r", "rad/s"),
    ];
}

#[cfg(test)]
mod tests {
    use super::Quantiles;

    #[test]
    fn absent_values_count_as_infinite() {
        let q = Quantiles::of([Some(1.0), None, Some(3.0), Some(2.0)].into_iter());
        assert_eq!((q.median, q.max), (Some(2.5), None));
        assert_eq!(Quantiles::of(std::iter::empty()).median, None);
    }
}
