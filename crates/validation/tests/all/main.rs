//! Models on recordings that they were not fitted to.

mod apportioned;
mod average;
mod correlations;
mod validity;
