//! What the pipeline's binaries share: parse, read, call the science, write.

#![forbid(unsafe_code)]
#![warn(missing_docs)]

/// Returns freed blocks of tables to the system: with the C library's allocator memory grows with the number of runs.
#[global_allocator]
static ALLOCATOR: mimalloc::MiMalloc = mimalloc::MiMalloc;

pub mod choice;
pub mod cli;
pub mod commands;
pub mod design;
pub mod failure;
pub mod ingest;
pub mod inputs;
mod interrupted;
pub mod ordered;
pub mod plan;
pub mod pool;
pub mod progress;
mod said;
pub mod sharded;
pub mod simulate;
mod stage;
pub mod umbrella;
mod verify;

pub use identification::{Estimator, RunEstimate, RunScore};
pub use in_memory::{Optimum, Study, StudyError};
pub use study::campaign_file::CampaignFile;
pub use vessel::{DictionaryFile, Vessel};
