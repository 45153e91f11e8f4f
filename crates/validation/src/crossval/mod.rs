//! Cross-validation: models simulated over runs or recordings that were left out of their estimate.

mod cross;
mod error;
mod folds;
mod physical;

pub use cross::{CrossOptions, CrossValidation, EstimatorScore, SourceScore, cross_validate};
pub use error::CrossError;
pub use folds::Folds;
pub use physical::{Fitting, cross_validate_forces};
