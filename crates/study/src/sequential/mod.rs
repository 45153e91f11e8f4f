//! Trials in rounds: `sequential.toml`, `sequential.parquet`, `sequential.json`.

mod document;
mod file;
mod table;

pub use document::document;
pub use file::SequentialFile;
pub use table::{ID, VERSION, columns, rows};
