//! Estimation of a vessel's parameters from measured runs, and validation of the estimates.
//!
//! Least squares and instrumental variables come from `regression`. This crate has the estimators that minimise
//! errors of simulations and predictions, the tests of what a model lacks, and the statements about pooled estimates.
//! Symbols: see `docs/notation.md`.

#![forbid(unsafe_code)]
#![warn(missing_docs)]

mod additional;
pub mod criticism;
mod estimator;
pub mod fitting;
pub mod pooled;
pub mod predictor;
mod quantiles;
mod recommendation;
pub mod refine;
mod repeated;
mod run_estimate;
pub mod runs;
pub mod search;
mod sensitivity;
mod signs;
mod status;
mod validate;
mod validation_runs;

pub use estimator::Estimator;
pub use quantiles::{Quantiles, Share};
pub use recommendation::{Contender, MOST_WITHOUT_ESTIMATE, Other, PairedDifference, Recommendation};
pub use repeated::{RepeatedEstimates, TRUSTED, relative_norms};
pub use run_estimate::{EstimateCovariance, RunEstimate};
pub use sensitivity::{
    OutputInformation, Simulated, output_information, output_informations, prediction_weights,
};
pub use signs::against_nominal;
pub use status::{EstimateStatus, ScoreStatus};
pub use validate::{FreeRun, free_runs, not_relative, parameter_error, rmse_norm};
pub use validation_runs::{Candidate, RunScore, ValidationRuns};
