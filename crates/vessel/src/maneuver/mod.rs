//! Maneuvers in the terms of a trial, turned into inputs by the model.

mod generate;
mod input_file;
mod spec;

pub use generate::{Generator, Realized};
pub use input_file::parse_inputs;
pub use spec::{DictionaryFile, Kind, ManeuverSpec, Shape};
