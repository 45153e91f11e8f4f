//! Cross-validation: models simulated over runs or recordings that were left out of their estimate.

mod folds;
mod stage;

pub use folds::{Fold, folds};
pub use stage::{Wanted, cross};
