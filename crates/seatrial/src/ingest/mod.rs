//! What the `ingest` stage does between log files and trajectories.

mod channels;
mod check;
mod config;
mod csv;
mod files;
mod load;
mod pattern;
mod quality;
mod recording;
mod rows;
mod segments;
mod simulated;
mod suspicion;
mod totals;

pub use channels::Plan;
pub use config::IngestFile;
pub use files::{Source, find};
pub use recording::{Outcome, ingest};
pub use rows::{RowsBuilder, schema};
pub use segments::check as check_segments;
pub use simulated::{SIMULATED_FILE, simulated_label};
pub use totals::{Totals, line};
