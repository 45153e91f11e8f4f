//! One estimate from many sub-experiments, and how far it can be trusted.
//!
//! A [`Part`] is one sub-experiment. Its instruments start anew at its first measured state, so the parts of a pooled
//! estimate need not follow each other. The sums of the parts add: [`fit`] takes the [`crate::Sums`] of whichever parts
//! are to be used, so that resampling and cross-validation never touch the data again.
//!
//! Plain numbers, no lanes: measured data sets are small.

mod bootstrap;
mod centre;
mod chi_square;
mod diagnosis;
mod fit;
mod output_error;
mod part;
mod regression;
mod residual_tests;
mod sandwich;
mod strength;
mod windows;

pub use bootstrap::{Bootstrap, Resampled, bootstrap, redraw};
pub use centre::Centring;
pub use chi_square::{chi_square_tail, normal_tails};
pub use diagnosis::{Diagnosis, diagnose};
pub use fit::{DegreeFit, Options, Prior, Solution, Status, fit};
pub use output_error::{OutputError, output_error};
pub use part::{Part, PartDiverged};
pub use regression::{DegreeRegression, Regression};
pub use residual_tests::{CrossCorrelation, Whiteness, cross_correlation, residuals, whiteness};
pub use sandwich::{default_bandwidth, sandwich};
pub use strength::strength;
pub use windows::{Score, Window, Windows};

/// Condition index above which columns count as collinear: Belsley, Kuh & Welsch, *Regression Diagnostics*, 1980. A just
/// identified instrumental-variable estimate has no moments: in such a direction it answers with noise.
pub const COLLINEAR: f64 = 30.0;
