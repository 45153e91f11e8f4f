//! Estimates of single runs, by every estimator.

mod criticised;
mod error;
mod estimators;
mod found;
mod instrumented;
mod physical;
mod refined;
mod searched;

pub use crate::estimator::{AdditionalUnknowns, Intercepts, UnknownCurrent};
pub use criticised::Asked;
pub use error::RunError;
pub use estimators::RunEstimators;
