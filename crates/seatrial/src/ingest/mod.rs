//! What the `ingest` stage reads for [`logs`] and tells of it.

mod read;
mod simulated;

pub use read::recorded;
pub use simulated::simulated_label;
