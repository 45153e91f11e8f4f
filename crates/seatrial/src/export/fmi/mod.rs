//! The model as a Functional Mock-up Unit (FMI 2.0, co-simulation), whose step is the model's.

mod archive;
mod description;
mod sources;

pub use sources::{COMPILED_WITH, PLATFORM};
