//! The table of trajectories: one row per sample, N + 1 rows per run of N samples.

mod kept;
mod label;
mod layout;
mod reacting;
mod read;
mod rows;
mod write;

pub use kept::KeptRuns;
pub use label::{DataLabel, label};
pub use layout::{ID, LEAST_ROW_BYTES, Layout, REACHED, SIMULATED_PER_SECOND, VERSION};
pub use reacting::Reacting;
pub use read::{TrajectoryReader, rate_of, refuse_shard};
pub use write::{BlockBuilder, MeasuredBlock, rows_per_block};
