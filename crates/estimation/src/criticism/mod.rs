//! Tests what a model lacks, by score tests of whitened errors.
//!
//! Candidates are added to the model with a parameter of zero: terms, a lag or delay of the inputs, a current. The
//! errors of the estimate and all sensitivities pass through the same Kalman filter, which whitens the errors, at the
//! states that it predicts, never at measured ones. Both are projected onto the complement of the estimated
//! parameters. Then T = sᵀV⁻¹s is χ² under the model, s being the products of the projected sensitivities and errors,
//! V those of the sensitivities; sums add over runs. Joint draws of all scores correct for the number of candidates.
//! If no noise is stated, it is found by its likelihood.

mod agreement;
mod calibrated;
mod chance;
mod channels;
mod criticise;
mod feedback;
mod found;
mod gate;
mod library;
mod likelihood;
mod noise;
mod problems;
mod refinement;
mod score;
mod tested;
mod waves;
mod white_noise;
mod with_noise;
mod words;

pub(crate) use calibrated::{Calibrated, calibrated};
pub(crate) use criticise::criticise_after;
pub use criticise::{criticise, criticise_each};
pub use feedback::Feedback;
pub use found::{Absent, Apart, Criticism, FoundDrift, FoundNoise, OtherNoise, Verdict};
pub use likelihood::restricted_likelihood;
pub use noise::NoiseKind;
pub(crate) use noise::{ENOUGH, Kinds};
pub use problems::Subject;
pub use tested::LEVEL;
pub use waves::oscillation;
pub use white_noise::clearer_under_white;
