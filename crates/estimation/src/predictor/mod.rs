//! Estimates that minimise the errors of predicted states.
//!
//! A predictor advances the state sample by sample with the model, x̂(k+1) = x̂(k) + φ(x̂(k))ᵀθ. Without gains it is
//! a free simulation, and the estimate one of *output error*; with the gains of an extended Kalman filter it is
//! corrected at every sample, and the estimate is one of *prediction error*, for runs with process noise. Forward
//! sensitivities ∂x̂/∂(θ, x̂(0)) are propagated with it (`sensitivity`), [`numerics::LANES`] runs at once; Levenberg
//! and Marquardt's method takes the steps. Near a minimum one adjoint pass, which gives the gradient alone, replaces
//! them.

mod errors;
mod levenberg_marquardt;
mod linear;
mod output_error;
mod prediction_error;

pub(crate) use errors::{held, of_terms, roots, scaled};
pub(crate) use levenberg_marquardt::{
    Asked, Ended, Minimum, Residuals, STEPS, Weighting, minimize, scaled_inverse,
};
pub use linear::{InitialState, Linear, Unknown};
pub(crate) use linear::{linearize, linearize_each};
pub use output_error::{Fit, Fitted, FoundSpread, Spread, output_error};
pub(crate) use prediction_error::errors_by_blocks;
pub use prediction_error::{innovations, prediction_error};

pub use crate::sensitivity::{
    Drift, Flow, ForceNoise, NoiseModel, Recordings, Sensitivities, Slopes, Step, free_sweep, slopes,
};
