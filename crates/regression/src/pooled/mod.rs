//! One regression of many sub-experiments, and tests of its residuals.
//!
//! A part is one sub-experiment. Its instruments restart at its first measured state, so the parts of a pooled
//! estimate need not be consecutive. The sums of the parts add: [`PooledSums`] stores little more than their total.
//! Computations that need the samples iterate over the [`Parts`] again, with one part's [`Regression`] at a time. So
//! runs need not be in memory: they are [`Recorded`] somewhere and read again.
//!
//! Scalars instead of lanes: measured data sets are small.

mod erased;
mod fit;
mod pooled_sums;
mod recorded;
mod regression;
mod runs;

pub use erased::{AnyParts, AnyRuns, Erased, Faults, Unread};
pub use fit::{
    COLLINEAR, DegreeFit, Diagnosis, Options, Prior, Solution, Status, collinear, first_named, joined,
    unidentified, weakest,
};
pub use pooled_sums::{Centring, NominalModel, NominalSource, PooledSums, diagnose, fit};
pub use recorded::{Drawn, LostInstruments, Part, PartView, Parts, Recorded, Windowed};
pub use regression::{
    CrossCorrelation, DegreeRegression, Meat, Regression, ResidualTests, Strength, Whiteness,
    default_bandwidth, residuals, residuals_of, sandwich, strength, whiteness,
};
pub use runs::{CutRuns, PooledRuns, SelectError};
