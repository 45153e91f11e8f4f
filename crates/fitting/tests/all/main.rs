//! Laws of fits to simulated recordings.

mod laws;
mod oracle;
mod ship;
