//! The table of trajectories: one row per sample, N + 1 rows per run of N samples.

mod label;
mod layout;
mod measured;
mod read;
mod write;

pub use label::{DataLabel, label};
pub use layout::{ID, Layout, VERSION};
pub use measured::MeasuredBlock;
pub use read::{TrajectoryReader, refuse_shard};
pub use write::{BlockBuilder, rows_per_block};
