//! Estimation of a vessel's parameters from measured runs, and validation of the estimates.
//!
//! Least squares and instrumental variables come from `regression`. This crate has the estimators that minimise
//! errors of simulations and predictions, the tests of what a model lacks, and the statements about pooled estimates.
//! Symbols: see `docs/notation.md`.

#![forbid(unsafe_code)]
#![warn(missing_docs)]

pub mod criticism;
mod estimator;
pub mod fitting;
pub mod pooled;
pub mod predictor;
mod recommendation;
pub mod refine;
pub mod runs;
pub mod search;
mod sensitivity;
mod validate;

pub use criticism::against_nominal;
pub use estimator::{EstimateCovariance, EstimateStatus, Estimator, RunEstimate, ScoreStatus};
pub use recommendation::{
    Contender, MOST_WITHOUT_ESTIMATE, Other, PairedDifference, Quantiles, Recommendation, RepeatedEstimates,
    Share, TRUSTED, relative_norms,
};
pub use sensitivity::{
    OutputInformation, Simulated, output_information, output_informations, prediction_weights, state_slopes,
    summed_information,
};
pub use validate::{
    EstimateView, FreeRun, RunScore, ValidationRuns, free_runs, not_relative, one_step_errors,
    parameter_error, rmse_norm,
};
