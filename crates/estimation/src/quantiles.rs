use numerics::statistics::{quantile, quantile_interval, sorted, wilson};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Quantiles over the runs; null where the quantile falls among runs without a value.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Quantiles {
    /// The smallest.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub min: Option<f64>,
    /// 10 %.
    pub q10: Option<f64>,
    /// 50 %.
    pub median: Option<f64>,
    /// 95 % interval of the median: two of the values, by their ranks; null at an end that there are too few values for or
    /// that falls among runs without a value.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub median_interval: Option<[Option<f64>; 2]>,
    /// 90 %.
    pub q90: Option<f64>,
    /// The same of the 90 % quantile.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub q90_interval: Option<[Option<f64>; 2]>,
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
            min: quantile(&sorted, 0.0),
            q10: quantile(&sorted, 0.1),
            median: quantile(&sorted, 0.5),
            median_interval: Some(quantile_interval(&sorted, 0.5)),
            q90: quantile(&sorted, 0.9),
            q90_interval: Some(quantile_interval(&sorted, 0.9)),
            q99: quantile(&sorted, 0.99),
            max: quantile(&sorted, 1.0),
        }
    }
}

/// A share of runs or realizations.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Share {
    /// The share.
    pub share: f64,
    /// Its 95 % interval (Wilson's); null of nothing.
    pub interval: Option<[f64; 2]>,
}

impl Share {
    /// `count` of `total`.
    pub fn of(count: usize, total: usize) -> Self {
        Self { share: count as f64 / total.max(1) as f64, interval: wilson(count as u64, total as u64) }
    }
}
