use std::fmt;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What instruments are made of.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum InstrumentKind {
    /// The nominal model simulated over the run's inputs from the run's initial state.
    Nominal,
    /// The measured regressors themselves: least squares.
    Regressors,
}

impl InstrumentKind {
    /// All of them.
    pub const ALL: [Self; 2] = [Self::Nominal, Self::Regressors];

    /// As in files and on the command line.
    pub fn name(self) -> &'static str {
        ["nominal", "regressors"][self as usize]
    }

    /// What it is, in a line.
    pub fn description(self) -> &'static str {
        match self {
            Self::Nominal => "The nominal model simulated over the run's inputs from the run's initial state",
            Self::Regressors => "The measured regressors themselves: least squares",
        }
    }
}

impl fmt::Display for InstrumentKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}
