//! A trial in rounds: design from what is known, sail, estimate, design the next round; against designs made once.

mod config;
mod knowledge;
mod planner;
mod stage;
mod stopping;
mod summary;
mod table;
mod trial;
mod voyage;

pub use config::{CrudeAbout, SequentialFile};
pub use stage::{Wanted, run};
pub use table::{ID, Row, VERSION, schema};
pub use trial::Arm;
