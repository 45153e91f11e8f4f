//! The crate as its users see it.

mod campaign;
mod closed_loop;
mod daylight;
mod grid;
mod handling;
mod legs;
mod moments;
mod pieces;
mod reacting;
mod rounds;
mod tide;
