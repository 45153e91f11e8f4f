use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::errors::{ComparedErrors, ComparedRecording};

refusal::choices! {
    /// Who takes part in a comparison.
    pub enum Standing {
        /// The model.
        Model = "model",
        /// Several models, whose trajectories are averaged.
        Average = "average of models",
        /// One of the models that are averaged, alone.
        Averaged = "model of the average",
        /// Another model.
        Other = "other model",
        /// The same structure by least squares of the same data.
        LeastSquares = "least squares",
        /// The mean of each recording.
        Mean = "mean of the data",
    }
}

/// One model over all windows.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ComparedModel {
    /// Which.
    pub name: Standing,
    /// Its place among the models that are averaged, from 1, if it is one of them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub place: Option<u64>,
    /// Over all windows.
    pub errors: ComparedErrors,
    /// One entry per run or recording.
    pub recordings: Vec<ComparedRecording>,
}

/// How far the error norm of another lies above the first model's, recording by recording, or window by window of one recording.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Difference {
    /// The other.
    pub name: Standing,
    /// Its place among the models that are averaged, from 1, if it is one of them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub place: Option<u64>,
    /// Pairs that were compared.
    pub pairs: u64,
    /// The median difference; null where it is infinite.
    pub median: Option<f64>,
    /// 95 % interval of that median; null at an infinite end. An interval that contains 0 tells no difference.
    pub interval: [Option<f64>; 2],
}
