//! The crate as its users see it.

mod campaign;
mod grid;
mod knowledge;
mod legs;
mod pieces;
