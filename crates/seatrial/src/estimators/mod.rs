//! Estimators of single runs, by name.

mod refined;
mod refusal;
mod rows;
mod simulated;

pub use identification::Estimator;
pub use refusal::refuse_if_none;
pub use rows::RunEstimators;
