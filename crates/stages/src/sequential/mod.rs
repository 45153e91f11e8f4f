//! A trial in rounds: design from what is known, sail, estimate, design the rest anew; against designs made once.

mod arm;
mod config;
mod estimate;
mod planner;
mod stage;
mod table;

pub use arm::Arm;
pub use config::SequentialFile;
pub use stage::{Wanted, run};
pub use table::{ID, Row, VERSION, schema};
