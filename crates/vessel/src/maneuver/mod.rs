//! Maneuvers in the terms of a trial, turned into inputs by the model.

mod candidates;
mod draw;
mod generate;
mod input_file;
mod signal;
mod spec;

pub use candidates::{CandidateKind, Exceeded, GenerateSpec, Limits};
pub use generate::{Generator, Realized};
pub use input_file::parse_inputs;
pub use signal::{Signal, SignalShape};
pub use spec::{DictionaryFile, Kind, ManeuverSpec, Shape};
