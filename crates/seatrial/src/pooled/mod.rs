//! One estimate from all runs of a file: measured data, cut into sub-experiments.

mod data;
mod estimator;
mod flags;
mod nominal;
mod single;
mod stage;
mod trust;
mod words;

pub use data::{Data, Stretch};
pub use estimator::{Estimated, Method, Pool, Used};
pub use flags::{PoolFlags, not_below, samples};
pub use nominal::{Nominal, NominalModel};
pub use single::{CollinearRun, collinear_run};
pub use stage::{Wanted, estimate};
pub use trust::{deviations, instrument_fit};
pub use words::{lost_instruments, unidentified};
