//! Logs as a ship's instruments would have written them, for studies whose real logs cannot be had.

mod csv;
mod file;
mod stage;

pub use csv::text;
pub use file::{DaySpec, LogsFile};
pub use stage::{Files, Made, SimulatedLogs, publish};
