//! The stages as programs: each parses, reads, calls the science and writes.

#![forbid(unsafe_code)]
#![warn(missing_docs)]

/// Returns freed blocks of tables to the system: with the C library's allocator memory grows with the number of runs.
#[global_allocator]
static ALLOCATOR: mimalloc::MiMalloc = mimalloc::MiMalloc;

pub mod commands;
pub mod design;
pub mod ingest;
pub mod monte_carlo;
pub mod plan;
pub mod simulate;
pub mod umbrella;

pub use frame::{choice, cli, failure, inputs, ordered, pool, progress, said, sharded, stage};
pub use identification::{Estimator, RunEstimate, RunScore};
pub use in_memory::{Optimum, Study, StudyError};
pub use maneuver::DictionaryFile;
pub use model::Vessel;
pub use study::campaign_file::CampaignFile;
