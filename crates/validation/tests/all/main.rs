//! Models on recordings that they were not fitted to.

mod average;
mod correlations;
mod slopes;
mod validity;
