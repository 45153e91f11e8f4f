use numerics::statistics::paired_median;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::pooled::FreeRunErrors;

/// The whole algorithm judged by recordings that it has not seen, beside the base structure.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct NestedScore {
    /// The ridge that was chosen without each fold; none where no candidate was left.
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
}

/// How far the base structure's norm of RMSE/std lies above the found models', recording by recording.
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
}

impl Margin {
    /// Of pairs of norms: the found model's and the base structure's.
    pub(super) fn of(pairs: &[[Option<f64>; 2]]) -> Option<Self> {
        let finite = |x: f64| Some(x).filter(|x| x.is_finite());
        let [low, median, high] = paired_median(pairs.iter().copied())?;
        Some(Self { pairs: pairs.len() as u64, median: finite(median), interval: [low, high].map(finite) })
    }
}
