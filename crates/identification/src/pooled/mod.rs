//! One estimate from many sub-experiments, and how far it can be trusted.
//!
//! A part is one sub-experiment. Its instruments start anew at its first measured state, so the parts of a pooled estimate
//! need not follow each other. The sums of the parts add: [`PooledSums`] keeps little besides their total. Whatever else
//! needs the samples goes through the [`Parts`] again, with one part's [`Regression`] at a time. So runs need not be in
//! memory: they are [`Recorded`] somewhere and read again.
//!
//! Plain numbers, no lanes: measured data sets are small.

mod around;
mod bootstrap;
mod centre;
mod continued;
mod delivered;
mod demand;
mod diagnosis;
mod enriched;
mod entangled;
mod estimate;
mod fit;
mod instrument_fit;
mod nominal;
mod part;
mod pool;
mod pooled_sums;
mod recorded;
mod regression;
mod resampler;
mod residual_tests;
mod runs;
mod sandwich;
mod search;
mod searched;
mod statements;
mod strength;
mod surroundings;
mod trust;
mod unfound;
mod windows;
mod words;

pub use bootstrap::{Bootstrap, Resample, Resampled, redraw};
pub use centre::Centring;
pub use delivered::{Covariance, Covered, Delivered, RecordingConstant, covered};
pub use diagnosis::{COLLINEAR, Diagnosis};
pub use enriched::{Added, Enriched, Grown, enriched, grown};
pub use estimate::{PoolError, Pooled, StandardErrors, estimate, resampled, standard_errors, unstated};
pub use fit::joined;
pub use fit::{DegreeFit, Options, Prior, Solution, Status};
pub use instrument_fit::InstrumentFit;
pub use nominal::{NominalModel, NominalSource};
pub use part::{LostInstruments, Part};
pub use pool::{Estimated, NoEstimate, Pool};
pub use pooled_sums::{PooledSums, diagnose, fit};
pub use recorded::{Drawn, PartView, Parts, Recorded};
pub use regression::{DegreeRegression, Regression};
pub use resampler::Resampling;
pub use residual_tests::{CrossCorrelation, Whiteness, residuals, whiteness};
pub use runs::{CutRuns, PooledRuns, SelectError};
pub use sandwich::{default_bandwidth, sandwich};
pub use searched::{Follow, Scales, Searched, least_errors};
pub use strength::Strength;
pub use strength::strength;
pub use surroundings::{FoundUnknown, Surroundings};
pub use trust::{DegreeTrust, InstrumentResidual, Judgement, ParameterTrust, SourceErrors};
pub use unfound::Unfound;
pub use windows::{FreeRunErrors, Score, deviations};
pub(crate) use words::{collinear, first_named, unidentified, weakest};
pub use words::{lies_above, listed};
