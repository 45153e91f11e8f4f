//! Laws of fits to simulated recordings.

mod laws;
mod ship;
