//! What a model lacks, by score tests of whitened errors.
//!
//! Whatever the model may lack is added to it with a parameter of zero: terms, a lag or delay of the inputs, a current. The errors
//! of the estimate and all sensitivities go through the same Kalman filter, which makes the errors white, at the states that it
//! predicts, never at measured ones. What the estimated parameters explain is taken out of both. Then T = sᵀV⁻¹s is χ² under
//! the model, s being the products of what is left of sensitivities and errors, V those of the sensitivities; sums add over
//! runs. How many are looked for is taken care of by draws of all scores together. Where no noise is stated it is found by its
//! likelihood.

mod agreement;
mod calibrated;
mod chance;
mod channels;
mod criticise;
mod feedback;
mod found;
mod gate;
mod library;
mod listened;
mod noise;
mod problems;
mod refinement;
mod score;
mod tested;
mod white_noise;
mod words;

pub(crate) use calibrated::{Calibrated, calibrated};
pub(crate) use criticise::criticise_after;
pub use criticise::{criticise, criticise_each};
pub use feedback::Feedback;
pub use found::{Absent, Apart, Criticism, FoundDrift, FoundNoise, OtherNoise, Verdict};
pub use noise::NoiseKind;
pub(crate) use noise::{ENOUGH, Kinds};
pub use problems::Subject;
pub use tested::LEVEL;
