//! Instruments of single runs, shared by those with the same inputs.

mod alike;
mod collinear;
mod instruments;
mod nominal_diverged;

pub use alike::{Doing, SharedInputs};
pub use collinear::{CollinearRun, collinear_run};
pub use instruments::{Prepared, RunInstruments};
pub use nominal_diverged::NominalDiverged;
