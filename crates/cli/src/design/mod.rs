//! `design`: the time of each maneuver, and `design refine`: the input signals themselves.

mod arguments;
mod problem;
pub mod refine;
mod refusal;
mod stage;

pub use arguments::Arguments;
