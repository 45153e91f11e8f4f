//! The contracts of a study: JSON documents, Parquet tables and hand-written TOML files, and their conversion to the
//! types of the scientific crates.

#![forbid(unsafe_code)]
#![warn(missing_docs)]

mod compared_model;
pub mod documents;
pub mod figure_goals;
pub mod folder;
mod notes;
pub mod parts;
pub mod plan;
pub mod pooled_set;
mod tables;
mod written;

pub use compared_model::Tried;
pub use notes::{
    Doubtful, LoggedHelm, at_rate, carry_contradicting, contradicting, note_contradicting, note_divided,
    note_reached, noted_contradicting,
};
pub use refusals::{invalid, refuse};
pub use tables::estimates::{note_seed, seed};
pub use tables::scores::{recommendations, validated};
pub use tables::{estimates, moments_table, resamples, scores, selection, track, trajectories};
pub use written::files::{beside, beyond, check_kind, role_of};
pub use written::{campaign_file, design_files, files, ingest_file, logs_file, sequential, ship_file};

/// Refusals of a file.
mod refusals {
    use std::path::Path;

    use files::Error;
    use refusal::Invalid;

    /// A refusal of what is invalid in `file`.
    pub fn invalid(file: &Path, invalid: &Invalid) -> Error {
        Error::invalid(file, invalid.clone())
    }

    /// A refusal of `file`.
    pub fn refuse(file: &Path, thing: &str, found: &str, expected: &str, remedy: &str) -> Error {
        Error::refuse(file, thing, found, expected, remedy)
    }
}
