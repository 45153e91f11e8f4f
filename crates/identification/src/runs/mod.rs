//! Estimates of single runs, by every estimator.

mod alike;
mod collinear;
mod criticised;
mod error;
mod estimators;
mod found;
mod instruments;
mod refined;
mod searched;

pub use crate::beside::{Beside, Intercepts, UnknownCurrent, UnknownWind};
pub use alike::{Alike, Doing};
pub use collinear::CollinearRun;
pub use criticised::Asked;
pub use error::{NominalDiverged, RunError};
pub use estimators::RunEstimators;
pub use instruments::{Prepared, RunInstruments};
