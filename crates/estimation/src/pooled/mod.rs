//! One estimate from many sub-experiments, and how far it can be trusted.
//!
//! Scalars instead of lanes: measured data sets are small.

mod ambient;
mod bootstrap;
mod continued;
mod delivered;
mod demand;
mod drawn;
mod enriched;
mod entangled;
mod estimate;
mod instrument_fit;
mod pool;
mod resampler;
mod search;
mod searched;
mod statements;
mod surroundings;
mod trust;
mod unfound;
mod windows;

pub use bootstrap::{Bootstrap, Resample, Resampled, redraw};
pub use delivered::{Covariance, Covered, Delivered, RecordingConstant, covered};
pub use drawn::Uncertain;
pub use enriched::{Added, Enriched, Grown, enriched, grown};
pub use entangled::entangled;
pub use estimate::{PoolError, Pooled, StandardErrors, estimate, resampled, standard_errors, unstated};
pub use instrument_fit::InstrumentFit;
pub use pool::{Estimated, NoEstimate, Pool};
pub use resampler::Resampling;
pub use searched::{Follow, Scales, Searched, least_errors};
pub use statements::lies_above;
pub use surroundings::{FoundUnknown, Surroundings};
pub use trust::{DegreeTrust, InstrumentResidual, Judgement, ParameterTrust, SourceErrors};
pub use unfound::Unfound;
pub use windows::{FreeRunErrors, Score, deviations};
