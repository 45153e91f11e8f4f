//! What `moments` and `design` share about designs: the noise that a covariance is predicted from, what is available, the
//! criterion, counts, how long an experiment has to be, and the document; and the stage `design` itself.

mod accuracy;
mod arguments;
mod available;
mod criterion;
mod document;
mod matrices;
mod models;
mod noise;
mod output_error;
pub mod refine;
mod refusal;
mod restricted;
mod segments;
mod sequence;
mod stage;
mod timed;
mod weights;
mod whole;

pub use accuracy::Wanted;
pub use arguments::Arguments;
pub use available::{Available, Experiment};
pub use criterion::{Asked, CovarianceCriterion, Criterion, CriterionName, OverModels};
pub use document::{Solved, document};
pub use matrices::{Estimated, information, middle};
pub use noise::NoiseModel;
pub use output_error::{OutputErrorNoise, ParameterDraw, Predicted, SimulateWith};
pub use refusal::no_design;
pub use restricted::{Few, restricted};
pub use segments::{Segments, counted};
pub use sequence::Sequencing;
pub use stage::stage;
pub use timed::{Question, Timed};
pub use weights::{Relative, squares, weights};
