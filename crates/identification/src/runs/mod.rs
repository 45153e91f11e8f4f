//! Estimates of single runs, by every estimator.

mod alike;
mod beside;
mod collinear;
mod criticised;
mod error;
mod estimators;
mod found;
mod instruments;
mod refined;
mod searched;

pub use alike::{Alike, Doing};
pub use beside::{Beside, Intercepts, UnknownCurrent};
pub use collinear::CollinearRun;
pub use criticised::Asked;
pub use error::{NominalDiverged, RunError};
pub use estimators::RunEstimators;
pub use instruments::{Prepared, RunInstruments};
