use std::fmt;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Which relative standard error is meant.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum AccuracyOf {
    /// The root of the sum of the squared relative standard errors.
    Overall,
    /// The largest relative standard error.
    PerParameter,
    /// The largest standard error of a figure of merit over the wanted one.
    Figures,
}

impl fmt::Display for AccuracyOf {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Overall => "root of the sum of squared relative standard errors",
            Self::PerParameter => "largest relative standard error",
            Self::Figures => "largest standard error of a figure over the wanted one",
        })
    }
}

/// The accuracy that is wanted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wanted {
    /// The standard error, relative to the parameters or to those that are wanted of figures.
    pub accuracy: f64,
    /// Which one.
    pub of: AccuracyOf,
    /// The longest experiment \[s\].
    pub longest_s: f64,
}

/// An accuracy that the longest experiment does not reach.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OutOfReach {
    /// What was wanted.
    pub wanted: Wanted,
    /// How long that takes; infinite if no time is enough \[s\].
    pub needed_s: f64,
    /// What the longest experiment reaches.
    pub best: f64,
}

impl fmt::Display for OutOfReach {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { wanted, needed_s, best } = self;
        write!(f, "found {} ({}), ", wanted.accuracy, wanted.of)?;
        match needed_s.is_finite() {
            true => write!(f, "which takes {needed_s:.1} s")?,
            false => f.write_str("which no time gives")?,
        }
        write!(f, ", expected one that {} s can reach: the best is {best:.4}", wanted.longest_s)
    }
}
