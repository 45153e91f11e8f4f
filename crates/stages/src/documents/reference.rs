use std::collections::BTreeMap;

use serde::Deserialize;

/// `reference.toml` of a study: results published elsewhere, shown beside ours and used for nothing else.
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
