use std::fmt;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What became of the estimate of a run, or of a degree of freedom.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum EstimateStatus {
    /// There is an estimate.
    #[serde(rename = "identified")]
    Identified,
    /// There is one that could not be refined further: a simulation with it diverged.
    #[serde(rename = "kept")]
    Kept,
    /// A direction of the parameters is not excited.
    #[serde(rename = "not identifiable")]
    NotIdentifiable,
    /// The search for an estimate did not converge.
    #[serde(rename = "not converged")]
    NotConverged,
}

impl EstimateStatus {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Identified, Self::Kept, Self::NotIdentifiable, Self::NotConverged];

    /// As in files.
    pub fn name(self) -> &'static str {
        ["identified", "kept", "not identifiable", "not converged"][self as usize]
    }

    /// Whether there is an estimate.
    pub fn estimated(self) -> bool {
        matches!(self, Self::Identified | Self::Kept)
    }
}

/// What became of a model that was to be simulated over validation data.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum ScoreStatus {
    /// It was simulated.
    #[serde(rename = "scored")]
    Scored,
    /// Its simulation diverged.
    #[serde(rename = "diverged")]
    Diverged,
    /// There is no model: a direction of the parameters is not excited.
    #[serde(rename = "not identifiable")]
    NotIdentifiable,
    /// There is no model: the search for one did not converge.
    #[serde(rename = "not converged")]
    NotConverged,
}

impl ScoreStatus {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Scored, Self::Diverged, Self::NotIdentifiable, Self::NotConverged];

    /// As in files.
    pub fn name(self) -> &'static str {
        ["scored", "diverged", "not identifiable", "not converged"][self as usize]
    }

    /// Whether there is an estimate.
    pub fn estimated(self) -> bool {
        matches!(self, Self::Scored | Self::Diverged)
    }
}

impl fmt::Display for EstimateStatus {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl fmt::Display for ScoreStatus {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}
