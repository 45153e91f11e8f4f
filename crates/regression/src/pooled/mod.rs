//! One regression of many sub-experiments, and tests of its residuals.
//!
//! A part is one sub-experiment. Its instruments restart at its first measured state, so the parts of a pooled
//! estimate need not be consecutive. The sums of the parts add: [`PooledSums`] stores little more than their total.
//! Computations that need the samples iterate over the [`Parts`] again, with one part's [`Regression`] at a time. So
//! runs need not be in memory: they are [`Recorded`] somewhere and read again.
//!
//! Scalars instead of lanes: measured data sets are small.

mod centre;
mod diagnosis;
mod erased;
mod fit;
mod nominal;
mod part;
mod pooled_sums;
mod recorded;
mod regression;
mod residual_tests;
mod runs;
mod sandwich;
mod strength;
mod windowed;
mod words;

pub use centre::Centring;
pub use diagnosis::{COLLINEAR, Diagnosis};
pub use erased::{AnyParts, AnyRuns, Erased, Faults, Unread};
pub use fit::{DegreeFit, Options, Prior, Solution, Status, joined};
pub use nominal::{NominalModel, NominalSource};
pub use part::{LostInstruments, Part};
pub use pooled_sums::{PooledSums, diagnose, fit};
pub use recorded::{Drawn, PartView, Parts, Recorded};
pub use regression::{DegreeRegression, Regression};
pub use residual_tests::{CrossCorrelation, ResidualTests, Whiteness, residuals, residuals_of, whiteness};
pub use runs::{CutRuns, PooledRuns, SelectError};
pub use sandwich::{Meat, default_bandwidth, sandwich};
pub use strength::{Strength, strength};
pub use windowed::Windowed;
pub use words::{collinear, first_named, unidentified, weakest};
