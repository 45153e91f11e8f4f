use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::force_criticism::TriedForce;

/// A search for forces that a ship lacks.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SearchedForces {
    /// Whether `model.json` has the forces that were found. Else it is the ship as she was: the interval of `nested.margin` holds
    /// 0, lies below it, or there is none; or none was found.
    pub delivered: bool,
    /// Forces that the search on all recordings found, in the order in which they were added.
    pub found: Vec<FoundForce>,
    /// What that search tried, one after the other.
    pub tried: Vec<TriedForce>,
    /// Why it tried no more; null where as many were added as are allowed.
    pub ended: Option<String>,
    /// The searches without each fold.
    pub without: Vec<ForcesWithoutFold>,
    /// Most forces that a search adds.
    pub most_added: u64,
    /// Weight of the priors.
    pub prior_weight: f64,
    /// Whether every window has a start of its own, or starts at its first measured sample.
    pub unknown_starts: bool,
    /// Cost of the ship as she was, fitted to all recordings: the mean of Huber's function of the windows' RMS errors in standard
    /// deviations, with what the priors add.
    pub base_cost: f64,
    /// That with the forces that were found.
    pub found_cost: f64,
}

/// A force that a search found.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FoundForce {
    /// `surge`, `sway` or `yaw`.
    pub degree: String,
    /// The product, as a term is written.
    pub term: String,
    /// Name of its number.
    pub parameter: String,
    /// The number's unit; `1` in the prime system.
    pub unit: String,
    /// The number, with all that were found fitted to all recordings.
    pub value: f64,
    /// Its standard error; null at a bound.
    pub standard_error: Option<f64>,
    /// Searches without a fold that found it too.
    pub found_by_folds: u64,
}

/// The search without the recordings of a fold.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ForcesWithoutFold {
    /// The fold.
    pub fold: u64,
    /// What was tried, one after the other.
    pub tried: Vec<TriedForce>,
    /// Why no more was tried; null where as many were added as are allowed.
    pub ended: Option<String>,
    /// Why there is no fit; null where there is one.
    pub failed: Option<String>,
}
