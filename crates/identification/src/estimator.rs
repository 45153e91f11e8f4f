use std::fmt;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// How parameters are estimated.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Estimator {
    /// Least squares, which measurement noise biases.
    Ls,
    /// Instrumental variables: instruments from the nominal model over the same inputs.
    Iv,
    /// Instrumental variables whose instruments are simulated again with the estimate. For single runs all signals are
    /// filtered by the estimate's poles.
    RefinedIv,
    /// Least errors of free simulations, with intercepts.
    OutputError,
    /// Least errors of one-sample predictions by an extended Kalman filter of the stated disturbances.
    PredictionError,
    /// Of pooled sub-experiments: instrumental variables where they identify a degree of freedom, least squares elsewhere.
    Auto,
}

impl Estimator {
    /// All of them.
    pub const ALL: [Self; 6] =
        [Self::Ls, Self::Iv, Self::RefinedIv, Self::OutputError, Self::PredictionError, Self::Auto];
    /// Those that estimate a single run, in the order of a comparison.
    pub const OF_RUNS: [Self; 5] =
        [Self::Ls, Self::Iv, Self::RefinedIv, Self::OutputError, Self::PredictionError];
    /// Those that estimate from pooled sub-experiments.
    pub const POOLED: [Self; 5] = [Self::Ls, Self::Iv, Self::RefinedIv, Self::Auto, Self::OutputError];
    /// Those whose accuracy a design predicts.
    pub const PREDICTED: [Self; 2] = [Self::Iv, Self::OutputError];

    /// As in files and on the command line.
    pub fn name(self) -> &'static str {
        ["ls", "iv", "refined-iv", "output-error", "prediction-error", "auto"][self as usize]
    }

    /// What it is, in a line.
    pub fn description(self) -> &'static str {
        match self {
            Self::Ls => "Least squares (biased by measurement noise)",
            Self::Iv => "Instrumental variables: instruments from the nominal model over the same inputs",
            Self::RefinedIv => {
                "Instrumental variables whose instruments are simulated again with the estimate; for single runs all \
                 signals are filtered by its poles"
            }
            Self::OutputError => "Least errors of free simulations, with intercepts",
            Self::PredictionError => {
                "Least errors of one-sample predictions by an extended Kalman filter of the disturbances that --campaign \
                 states"
            }
            Self::Auto => {
                "Of pooled sub-experiments: instrumental variables where they identify a degree of freedom, least squares \
                 elsewhere"
            }
        }
    }

    /// Whether instruments are simulated for it, so that collinear ones leave it without an answer.
    pub fn by_instruments(self) -> bool {
        matches!(self, Self::Iv | Self::RefinedIv)
    }

    /// Whether it searches for a minimum, which may not converge.
    pub fn searches(self) -> bool {
        matches!(self, Self::OutputError | Self::PredictionError)
    }
}

impl fmt::Display for Estimator {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}
