//! Estimators of single runs, by name.

mod refined;
mod refusal;
mod rows;
mod simulated;

use clap::ValueEnum;

pub use refusal::refuse_if_none;
pub use rows::RunEstimators;

use crate::pooled::Method;

/// An estimator.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Estimator {
    /// Least squares (biased by measurement noise)
    Ls,
    /// Instrumental variables: instruments from the nominal model over the same inputs
    Iv,
    /// Instrumental variables whose instruments are simulated again with the estimate, all signals filtered by its poles (with
    /// --pool: without the filter)
    RefinedIv,
    /// Least errors of a free simulation, with intercepts
    OutputError,
    /// Least errors of one-sample predictions by an extended Kalman filter of the disturbances that --campaign states
    PredictionError,
    /// With --pool: instrumental variables where they identify a degree of freedom, least squares elsewhere
    Auto,
}

impl Estimator {
    /// Those that --compare runs, in the order of the table.
    pub const COMPARED: [Self; 5] =
        [Self::Ls, Self::Iv, Self::RefinedIv, Self::OutputError, Self::PredictionError];

    /// The same for pooled sub-experiments, where there is one.
    pub fn pooled(self) -> Option<Method> {
        match self {
            Self::Ls => Some(Method::Ls),
            Self::Iv => Some(Method::Iv),
            Self::RefinedIv => Some(Method::RefinedIv),
            Self::OutputError => Some(Method::OutputError),
            Self::Auto => Some(Method::Auto),
            Self::PredictionError => None,
        }
    }
}
