//! Laws of fits to simulated recordings.

mod criticism;
mod information;
mod laws;
mod oracle;
mod ship;
