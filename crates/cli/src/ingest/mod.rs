//! What the `ingest` stage reads for [`logs`] and tells of it.

mod simulated;

pub use simulated::simulated_label;
