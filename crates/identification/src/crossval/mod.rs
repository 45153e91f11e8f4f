//! Cross-validation: models simulated over runs or recordings that were left out of their estimate.

mod cross;
mod folds;

pub use cross::{CrossError, CrossOptions, CrossValidation, EstimatorScore, SourceScore, cross_validate};
