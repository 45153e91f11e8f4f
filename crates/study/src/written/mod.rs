//! What is written by hand: the files of a study in TOML, as types.

pub mod campaign_file;
pub mod design_files;
pub mod files;
pub mod ingest_file;
pub mod logs_file;
pub(crate) mod reference;
pub mod sequential;
pub mod ship_file;
