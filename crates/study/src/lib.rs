//! The contracts of a study: JSON documents, Parquet tables and hand-written TOML files, and their conversion to the
//! types of the scientific crates.

#![forbid(unsafe_code)]
#![warn(missing_docs)]

mod beyond;
pub mod campaign_file;
pub mod design_files;
pub mod documents;
mod doubtful;
pub mod estimates;
pub mod figure_goals;
pub mod files;
pub mod folder;
pub mod hand_written;
pub mod ingest_file;
pub mod kept;
mod logged_helm;
pub mod logs_file;
pub mod moments_table;
mod outdated;
pub mod parts;
pub mod plan;
pub mod pooled_set;
mod rate;
mod reached;
mod recommendation;
mod refusal;
pub mod resamples;
pub mod scores;
mod seed;
pub mod selection;
pub mod sequential;
pub mod ship_file;
pub mod tallies;
mod term_lists;
pub mod track;
pub mod trajectories;
mod tried;
mod validated;
pub mod vessel_text;

pub use beyond::beyond;
pub use doubtful::Doubtful;
pub use files::{beside, check_kind, role_of};
pub use logged_helm::LoggedHelm;
pub use rate::{at_rate, note_divided};
pub use reached::note_reached;
pub use recommendation::recommendations;
pub use refusal::{invalid, refuse};
pub use seed::{note_seed, seed};
pub use term_lists::TermLists;
pub use tried::Tried;
pub use validated::validated;
