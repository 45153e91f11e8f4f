//! Laws of fits to simulated recordings.

mod information;
mod laws;
mod oracle;
mod ship;
