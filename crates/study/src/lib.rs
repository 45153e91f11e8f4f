//! The contracts of a study: JSON documents, Parquet tables and hand-written TOML files, and their conversion to the
//! types of the scientific crates.

#![forbid(unsafe_code)]
#![warn(missing_docs)]

pub mod campaign_file;
pub mod design_files;
pub mod documents;
pub mod estimates;
pub mod figure_goals;
pub mod files;
pub mod folder;
pub mod ingest_file;
pub mod logs_file;
pub mod moments_table;
mod notes;
pub mod parts;
pub mod plan;
pub mod pooled_set;
pub mod resamples;
pub mod scores;
pub mod selection;
pub mod sequential;
pub mod ship_file;
pub mod track;
pub mod trajectories;
mod tried;

use std::path::Path;

use ::files::Error;
use ::refusal::Invalid;

pub use estimates::{note_seed, seed};
pub use files::{TermLists, beside, beyond, check_kind, role_of};
pub use notes::{Doubtful, LoggedHelm, at_rate, note_divided, note_reached};
pub use scores::{recommendations, validated};
pub use tried::Tried;

/// A refusal of what is invalid in `file`.
pub fn invalid(file: &Path, invalid: &Invalid) -> Error {
    Error::invalid(file, invalid.clone())
}

/// A refusal of `file`.
pub fn refuse(file: &Path, thing: &str, found: &str, expected: &str, remedy: &str) -> Error {
    Error::refuse(file, thing, found, expected, remedy)
}
