//! One estimate from many sub-experiments, and how far it can be trusted.
//!
//! A [`Part`] is one sub-experiment. Its instruments start anew at its first measured state, so the parts of a pooled
//! estimate need not follow each other. The sums of the parts add: [`fit`] takes the [`crate::Sums`] of whichever parts
//! are to be used, so that resampling and cross-validation never touch the data again. Whatever else needs the samples makes
//! the [`Regression`] of one part at a time.
//!
//! Plain numbers, no lanes: measured data sets are small.

mod bootstrap;
mod centre;
mod delivered;
mod diagnosis;
mod estimate;
mod fit;
mod nominal;
mod output_error;
mod part;
mod pool;
mod regression;
mod residual_tests;
mod runs;
mod sandwich;
mod statements;
mod strength;
mod trust;
mod windows;
mod words;

pub use bootstrap::{Bootstrap, Resampled, bootstrap, redraw};
pub use centre::Centring;
pub(crate) use delivered::covered;
pub use delivered::{Covariance, Covered, Delivered, RecordingConstant};
pub use diagnosis::{COLLINEAR, Diagnosis, diagnose};
pub use estimate::{PoolError, Pooled, estimate};
pub(crate) use fit::joined;
pub use fit::{DegreeFit, Options, Prior, Solution, Status, fit};
pub use nominal::{NominalModel, NominalSource};
pub use output_error::{OutputError, output_error};
pub use part::{LostInstruments, Part};
pub use pool::{Estimated, Pool};
pub use regression::{DegreeRegression, Regression, Regressions, Remade};
pub use residual_tests::{CrossCorrelation, Whiteness, cross_correlation, residuals, whiteness};
pub use runs::{PooledRuns, SelectError};
pub use sandwich::{default_bandwidth, sandwich};
pub use strength::strength;
pub use trust::{DegreeTrust, InstrumentResidual, Judgement, ParameterTrust, SourceErrors};
pub use windows::{FreeRunErrors, Score, deviations};
pub use words::listed;
pub(crate) use words::{collinear, first_named, unidentified, weakest};
