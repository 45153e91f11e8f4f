//! Input signals that minimise the variance of an output-error estimate, by adjoint gradients.
//!
//! One experiment is a run of N samples from a given state. The objective is f = log tr(G cov θ̃) with cov θ̃ = F⁻¹(E + P)F⁻¹
//! of its free simulation ([`crate::output_information`]) and G the weights of the parameters' variances. Its
//! gradient by all inputs of all samples takes one pass forward and one backward ([`TraceCriterion`]); [`refine`]
//! follows it within limits of the inputs, of their rates and of the simulated motion.

mod criterion;
mod gradient;
mod lagrangian;
mod search;
mod signal;

pub use criterion::{Forward, TraceCriterion};
pub use lagrangian::SignalLimits;
pub use search::{Effort, MARGIN, Refined, refine};
