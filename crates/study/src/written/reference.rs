use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::Deserialize;

use validation::selection::PublishedLimits;

/// `reference.toml` of a study: results published elsewhere, for comparison. They change no result: the limits of a
/// selection study only set from where realizations are counted.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Reference {
    /// The publication.
    pub source: String,
    /// Other uses than comparison, if any: sentences for the page.
    pub used: Option<String>,
    /// Published shares of the optimized design, by maneuver.
    #[serde(default)]
    #[schemars(extend("additionalProperties" = {"type": "number", "minimum": 0, "maximum": 1, "x-expected": "a share from 0 to 1"}))]
    pub shares: BTreeMap<String, f64>,
    /// Published shares of runs under the bounds, by design.
    #[serde(default)]
    pub designs: BTreeMap<String, Published>,
    /// A published selection study.
    pub selection: Option<PublishedSelection>,
    /// Values of captive tests for numbers of a ship with forces, by name: in the prime system where a number has one, else in
    /// SI units.
    #[serde(default)]
    pub derivatives: BTreeMap<String, f64>,
}

/// A published selection study: the limits of its figures, and its statements.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PublishedSelection {
    /// RMSE in surge from which values are truncated \[m/s\].
    #[schemars(extend("exclusiveMinimum" = 0.0, "x-unit" = "m/s"))]
    pub limit_u: f64,
    /// In sway \[m/s\].
    #[schemars(extend("exclusiveMinimum" = 0.0, "x-unit" = "m/s"))]
    pub limit_v: f64,
    /// In yaw rate \[rad/s\].
    #[schemars(extend("exclusiveMinimum" = 0.0, "x-unit" = "rad/s"))]
    pub limit_r: f64,
    /// The norm of the three.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub limit_norm: f64,
    /// Statements about the result.
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

/// The published results of one way of picking.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PublishedPicks {
    /// Share of degenerate realizations.
    #[schemars(range(min = 0.0, max = 1.0), extend("x-expected" = "a share from 0 to 1"))]
    pub degenerate_share: Option<f64>,
    /// The best case, shown next to the other's.
    pub best: Option<String>,
    /// The worst case, shown next to the other's.
    pub worst: Option<String>,
}

/// Published shares of one design.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Published {
    /// Share of runs below the bound on the parameter error.
    pub parameter_error_share: PublishedShare,
    /// Share of runs below the bound on the simulation error.
    pub simulation_error_share: PublishedShare,
}

/// A share as printed: a value, or more than a value.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum PublishedShare {
    /// As printed.
    Value(#[schemars(range(min = 0.0, max = 1.0), extend("x-expected" = "a share from 0 to 1"))] f64),
    /// Printed as "more than".
    Above {
        /// The printed bound.
        #[schemars(range(min = 0.0, max = 1.0), extend("x-expected" = "a share from 0 to 1"))]
        above: f64,
    },
}
