use std::collections::BTreeMap;

use serde::Deserialize;

use validation::selection::PublishedLimits;

/// `reference.toml` of a study: results published elsewhere, for comparison. They change no result: the limits of a selection
/// study only say from where on realizations are counted.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Reference {
    /// Where they were published.
    pub source: String,
    /// Published shares of the optimized design, by maneuver.
    #[serde(default)]
    pub shares: BTreeMap<String, f64>,
    /// Published shares of runs under the bounds, by design.
    #[serde(default)]
    pub designs: BTreeMap<String, Published>,
    /// A published selection study.
    pub selection: Option<PublishedSelection>,
}

/// A published selection study: where its figures end, and what is told of them.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PublishedSelection {
    /// RMSE in surge from which values are truncated \[m/s\].
    pub limit_u: f64,
    /// In sway \[m/s\].
    pub limit_v: f64,
    /// In yaw rate \[rad/s\].
    pub limit_r: f64,
    /// The norm of the three.
    pub limit_norm: f64,
    /// What is said of the result.
    #[serde(default)]
    pub statements: Vec<String>,
    /// The optimized selection.
    #[serde(default)]
    pub optimized: PublishedPicks,
    /// The random selection.
    #[serde(default)]
    pub random: PublishedPicks,
}

impl From<&PublishedSelection> for PublishedLimits {
    fn from(published: &PublishedSelection) -> Self {
        Self {
            rmse_norm: published.limit_norm,
            rmse_u: published.limit_u,
            rmse_v: published.limit_v,
            rmse_r: published.limit_r,
        }
    }
}

/// What was published of one way of picking.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PublishedPicks {
    /// Share of degenerate realizations.
    pub degenerate_share: Option<f64>,
    /// The best case, beside the other's.
    pub best: Option<String>,
    /// The worst case, beside the other's.
    pub worst: Option<String>,
}

/// Published shares of one design.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Published {
    /// Share of runs below the bound on the parameter error.
    pub parameter_error_share: PublishedShare,
    /// Share of runs below the bound on the simulation error.
    pub simulation_error_share: PublishedShare,
}

/// A share as printed: a value, or more than a value.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(untagged)]
pub enum PublishedShare {
    /// As printed.
    Value(f64),
    /// Printed as "more than".
    Above {
        /// The printed bound.
        above: f64,
    },
}
