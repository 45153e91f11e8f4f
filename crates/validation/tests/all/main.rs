//! Models on recordings that they were not fitted to.

mod apportioned;
mod correlations;
mod validity;
