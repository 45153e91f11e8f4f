//! What the `ingest` stage reads for [`logs`] and tells of it.

mod files;
mod read;
mod simulated;

pub use files::find;
pub use read::recorded;
pub use simulated::simulated_label;
