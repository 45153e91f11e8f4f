//! Estimates of single runs, by every estimator.

mod collinear;
mod error;
mod estimators;
mod found;
mod instruments;
mod refined;
mod searched;

pub use collinear::CollinearRun;
pub use error::{NominalDiverged, RunError};
pub use estimators::RunEstimators;
pub use instruments::{Prepared, RunInstruments};
