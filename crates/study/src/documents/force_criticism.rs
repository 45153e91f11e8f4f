use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What is wrong with a fitted ship, by the recordings that she was fitted to.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ForceCriticism {
    /// Whether something is wrong beyond chance.
    pub rejected: bool,
    /// How probable it is in a right model that anything tested seems as likely to be missing; null where a sign is wrong.
    pub p_value: Option<f64>,
    /// Parts of the recordings that count as independent.
    pub units: u64,
    /// Whether these are whole windows; else pieces of them.
    pub whole_windows: bool,
    /// Signs of geometry that were turned, the one with the lowest cost first.
    pub signs: Vec<TriedSign>,
    /// Inputs, the one that lowers the cost most first. None where a sign is wrong.
    pub late: Vec<LateActuator>,
    /// Forces that may be missing, the likeliest first. None where a sign is wrong.
    pub absent: Vec<AbsentForce>,
    /// Number of forces that were tested.
    pub tested: u64,
    /// Forces that cannot be told from the ship's own.
    pub hidden: Vec<String>,
    /// Why lags and forces were not tested; null where they were.
    pub not_tested: Option<String>,
    /// The verdict and what follows, in words.
    pub statements: Vec<String>,
}

/// A sign of the ship's geometry that was turned, after which she was fitted again.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TriedSign {
    /// What was turned, in words.
    pub turned: String,
    /// By which share the cost falls; below 0 where it rises, null where no simulation is finite.
    pub share: Option<f64>,
    /// Windows that are followed better.
    pub windows_better: u64,
    /// All windows.
    pub windows: u64,
    /// How probable it is by chance that any of the signs seems as wrong.
    pub p_value: f64,
    /// Whether the recordings speak for the turned sign.
    pub wrong: bool,
}

/// An input that may act later than the model has it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LateActuator {
    /// The input.
    pub input: String,
    /// By how much it acts later \[s\]; below 0 earlier.
    pub late_s: f64,
    /// The standard error of that \[s\].
    pub standard_error: f64,
    /// By which share the cost would fall.
    pub share: f64,
    /// How probable it is in a right model that anything tested seems as likely.
    pub p_value: f64,
    /// What fits best where that is certain: `dead time` or `lag`.
    pub kind: Option<String>,
    /// Its time \[s\].
    pub time_s: Option<f64>,
    /// By which share the cost falls with it.
    pub share_fitted: Option<f64>,
    /// The same with the other kind.
    pub share_of_other: Option<f64>,
}

/// A force that the ship may lack: a number times a product.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct AbsentForce {
    /// `surge`, `sway` or `yaw`.
    pub degree: String,
    /// The product, as a term is written.
    pub term: String,
    /// The number if it were added, in SI units.
    pub value: f64,
    /// The standard error of that.
    pub standard_error: f64,
    /// Its SI unit.
    pub unit: String,
    /// The number in the prime system; null with channels that it does not scale.
    pub prime_value: Option<f64>,
    /// By which share the cost would fall.
    pub share: f64,
    /// How probable it is in a right model that anything tested seems as likely.
    pub p_value: f64,
    /// Whether it may be what is missing: nothing else lowers the cost by much more.
    pub candidate: bool,
}

/// A force that was tried as an addition to the ship, on recordings that were left out.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TriedForce {
    /// `surge`, `sway` or `yaw`.
    pub degree: String,
    /// The product, as a term is written.
    pub term: String,
    /// Name of its number.
    pub parameter: String,
    /// By which share the cost of recordings that were left out of both fits falls with it; below 0 where it rises. Folds count
    /// in which the ship without it has a fit and follows them. Null where these are fewer than two, or where with it a fold has
    /// no fit or a simulation diverges.
    pub share_left_out: Option<f64>,
    /// The standard error of that, over the folds.
    pub standard_error: Option<f64>,
    /// Number of folds that whole recordings were dealt into.
    pub folds: u64,
    /// Whether it was added: the share is above its standard error.
    pub added: bool,
}
