//! `design`: the time of each maneuver, `design refine`: the input signals themselves, and `design update`: what became of its promise.

mod arguments;
mod problem;
pub mod refine;
mod refusal;
mod stage;
pub mod update;

pub use arguments::Arguments;
