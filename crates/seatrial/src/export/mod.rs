//! A vessel's model as source text for other tools: Python, C, MATLAB or Octave, and a Functional Mock-up
//! Unit.
//!
//! [`Portable`] is the model in a form common to all languages: channels, parameters and equations under
//! names that are identifiers everywhere. A target turns it into text in memory; the caller writes the files
//! and builds the library.
//!
//! The generated code computes what [`ship::engine::Compiled::step`] does in the same order, so that both agree to the last bit
//! where a processor does not fuse multiplication and addition.

mod fmi;
mod languages;
mod portable;
mod ship;
mod target;
pub mod text;

pub use fmi::{COMPILED_WITH, PLATFORM};
pub use portable::{Channel, Knowledge, Origin, Parameter, Portable, Range, Summand, Tied};
pub use ship::Ship;
pub use target::Target;
pub use text::{Identifiers, file_name, fill};
