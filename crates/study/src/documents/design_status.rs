use std::fmt;

use design::Status;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What is known of a design.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum DesignStatus {
    /// Proved global.
    Optimal,
    /// First-order optimal, not proved global.
    Stationary,
    /// The gap was not reached.
    Stalled,
    /// Few or long maneuvers, see `restricted`.
    Restricted,
    /// The least largest of the relative errors, see `accuracy`.
    #[serde(rename = "least largest")]
    LeastLargest,
    /// One maneuver of refined inputs.
    Refined,
}

impl From<Status> for DesignStatus {
    fn from(status: Status) -> Self {
        match status {
            Status::Optimal => Self::Optimal,
            Status::Stationary => Self::Stationary,
            Status::Stalled => Self::Stalled,
        }
    }
}

impl fmt::Display for DesignStatus {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(
            ["optimal", "stationary", "stalled", "restricted", "least largest", "refined"][*self as usize],
        )
    }
}
