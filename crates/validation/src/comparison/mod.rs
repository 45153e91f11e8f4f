//! Comparison of a model with others on recordings that it was not fitted to.
//!
//! Every window is simulated freely from its first measured state by each model. Their errors are reported over all
//! windows and per recording, and compared with the mean of the data as a baseline.

mod bands;
mod compare;
mod correlations;
mod covered;
mod errors;
mod simulated;
mod spread;
mod standing;
mod validity;
mod verdict;

pub use bands::{Bands, Known};
pub use compare::{CompareOptions, Compared, Traced, compare};
pub use correlations::{
    ErrorCorrelations, ErrorKind, InputCorrelations, autocorrelations, cross_correlations,
};
pub use covered::{Counter, Outside};
pub use errors::{ComparedErrors, ComparedRecording};
pub use simulated::{Contestant, Ship};
pub use spread::Spread;
pub use standing::{ComparedModel, Difference, Standing};
pub use validity::{Magnitudes, STRETCH_S, Unlike, Validity};
