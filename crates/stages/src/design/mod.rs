//! What `moments` and `design` share about designs: the noise that a covariance is predicted from, what is available, the
//! criterion, counts, and the document.

mod available;
mod criterion;
mod document;
mod matrices;
mod noise;
mod refusal;
mod segments;

pub use available::{Available, Experiment};
pub use criterion::{Criterion, CriterionName, Relative, weights};
pub use document::{Solved, document};
pub use matrices::{information, middle};
pub use noise::NoiseModel;
pub use refusal::no_design;
pub use segments::{Segments, counted};
