use numerics::statistics::paired_median;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::pooled::FreeRunErrors;

/// The whole algorithm judged by recordings that it has not seen, beside the base structure.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct NestedScore {
    /// The ridge that was chosen without each fold; none where no candidate was left. Empty for a ship with forces.
    pub ridges: Vec<Option<f64>>,
    /// Over all recordings; none where a fold has no model, or a window diverged.
    pub search: Option<FreeRunErrors>,
    /// Those of the base structure.
    pub base: Option<FreeRunErrors>,
    /// As `search`, over windows of which one begins at every quarter of another: where the first begins hardly counts.
    pub search_overlapping: Option<FreeRunErrors>,
    /// Those of the base structure.
    pub base_overlapping: Option<FreeRunErrors>,
    /// Windows in which the found models diverged.
    pub diverged: u64,
    /// Recording by recording.
    pub recordings: Vec<NestedRecording>,
    /// Against the base structure.
    pub margin: Option<Margin>,
    /// The mean trajectory of several models that were found so, where an average was asked for.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub average: Option<NestedAverage>,
}

/// The mean trajectory of several models on recordings that were left out of finding every one of them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct NestedAverage {
    /// Over all recordings; none where a fold lacks a model, or a window diverged.
    pub errors: Option<FreeRunErrors>,
    /// The same over windows of which one begins at every quarter of another.
    pub overlapping: Option<FreeRunErrors>,
    /// Windows in which a model diverged.
    pub diverged: u64,
    /// How far the single model's norm of RMSE/std lies above, recording by recording.
    pub over_search: Option<Margin>,
    /// How far the base structure's does.
    pub over_base: Option<Margin>,
}

/// How far one norm of RMSE/std lies above another, recording by recording: the base structure's above the found models', where
/// nothing else is said.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Margin {
    /// Recordings that were compared.
    pub pairs: u64,
    /// The median difference; null where it is infinite.
    pub median: Option<f64>,
    /// 95 % interval of that median; null at an infinite end. An interval that contains 0 tells no difference.
    pub interval: [Option<f64>; 2],
}

/// One recording when it was left out.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct NestedRecording {
    /// Its name.
    pub source: String,
    /// The fold it is in.
    pub fold: u64,
    /// Errors of the found model, against the standard deviations of its own states.
    pub search: Option<FreeRunErrors>,
    /// Those of the base structure.
    pub base: Option<FreeRunErrors>,
    /// Norm of RMSE over the standard deviations of all recordings' states.
    pub search_norm: Option<f64>,
    /// That of the base structure.
    pub base_norm: Option<f64>,
    /// Windows in which the found model diverged.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub search_diverged: u64,
    /// Errors of the mean trajectory, where an average was asked for.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub average: Option<FreeRunErrors>,
    /// Its norm.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub average_norm: Option<f64>,
}

// Serde passes a reference.
#[allow(clippy::trivially_copy_pass_by_ref)]
fn is_zero(count: &u64) -> bool {
    *count == 0
}

impl Margin {
    /// Whether the second norm is larger beyond chance: the interval lies above 0.
    pub fn is_above(&self) -> bool {
        self.interval[0].is_some_and(|low| low > 0.0)
    }

    /// From pairs of norms: the own one and the other.
    pub(crate) fn of(pairs: &[[Option<f64>; 2]]) -> Option<Self> {
        let finite = |x: f64| Some(x).filter(|x| x.is_finite());
        let [low, median, high] = paired_median(pairs.iter().copied())?;
        Some(Self { pairs: pairs.len() as u64, median: finite(median), interval: [low, high].map(finite) })
    }
}
