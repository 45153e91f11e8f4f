use std::fmt;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// How the instruments' mean is removed: how many intercepts a degree of freedom has.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum MeanRemoval {
    /// Not at all.
    None,
    /// Segment by segment: an intercept per segment.
    Batch,
    /// Over the whole experiment: one intercept.
    Complete,
}

impl MeanRemoval {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::None, Self::Batch, Self::Complete];

    /// As in files and on the command line.
    pub fn name(self) -> &'static str {
        ["none", "batch", "complete"][self as usize]
    }

    /// What it is, in a line.
    pub fn description(self) -> &'static str {
        ["Not at all", "Segment by segment", "Over the whole experiment"][self as usize]
    }
}

impl fmt::Display for MeanRemoval {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}
