//! Models on recordings that they were not fitted to.

mod average;
mod correlations;
mod exact_sums;
mod folds;
mod forces;
mod selection;
mod slopes;
mod validity;
