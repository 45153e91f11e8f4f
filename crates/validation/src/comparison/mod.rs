//! Comparison of a model with others on recordings that it was not fitted to.
//!
//! Every window is simulated freely from its first measured state by each model. Their errors are reported over all
//! windows and per recording, and compared with the mean of the data as a baseline.

mod bands;
mod compare;
mod simulated;
mod validity;

pub use bands::{Bands, Counter, EstimatedErrors, Outside, Spread};
pub use compare::{CompareOptions, Compared, Traced, compare};
pub use simulated::{
    ComparedErrors, ComparedModel, ComparedRecording, Contestant, Difference, Ship, Standing,
};
pub use validity::{
    ErrorCorrelations, ErrorKind, InputCorrelations, Magnitudes, STRETCH_S, Unlike, Validity,
    autocorrelations, cross_correlations,
};
