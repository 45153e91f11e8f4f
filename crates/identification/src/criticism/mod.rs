//! What a model lacks, by score tests of whitened errors.
//!
//! Whatever the model may lack is added to it with a parameter of zero: terms, a lag or delay of the inputs, a current. The errors
//! of the estimate and all sensitivities go through the same Kalman filter, which makes the errors white, at the states that it
//! predicts, never at measured ones. What the estimated parameters explain is taken out of both. Then T = sᵀV⁻¹s is χ² under
//! the model, s being the products of what is left of sensitivities and errors, V those of the sensitivities; sums add over
//! runs. Holm's method takes care of how many are looked for. Where no noise is stated it is found by its likelihood.

mod channels;
mod criticise;
mod found;
mod library;
mod noise;
mod score;
mod words;

pub use criticise::{LEVEL, Subject, criticise};
pub use found::{Absent, Criticism};
