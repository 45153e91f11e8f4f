use super::noise::{Guess, NoiseKind};
use super::problems::{Problems, Subject};

/// Twice the restricted log-likelihood of all runs of `subject`, up to a constant, by which kinds of noise are compared. The
/// model is linearised about free simulations with `parameters`; what they explain counts for nothing.
///
/// `levels`, [`NoiseKind::levels`] of them: standard deviations of the noise of u, v \[m/s\], r \[rad/s\]; those of forces
/// or sensors, and their times \[s\]; that of the current \[m/s\], and its time \[s\].
pub fn restricted_likelihood(subject: &Subject, parameters: &[f64], kind: NoiseKind, levels: &[f64]) -> f64 {
    Problems::new(subject, true).turns(0).likelihood(parameters, Guess::new(kind, levels))
}
