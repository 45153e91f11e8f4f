//! Force models fitted to recordings: output error with priors, and the errors of its estimates.
//!
//! A [`Problem`] has recordings cut into windows. Each window is simulated freely, by steps of order 4 with inputs linear
//! between samples. [`Problem::fit`] finds the free parameters θ and the state that each window starts from: they minimise
//! the mean over windows of Huber's function of the window's RMS error, plus what the priors hold against θ. Errors are
//! counted in standard deviations of the measured states. Derivatives are tangents of the steps, eight windows side by
//! side; windows are simulated in parallel and added in order, so that the result has the same bits for any number of
//! threads.

#![forbid(unsafe_code)]
#![warn(missing_docs)]

mod estimates;
mod fit;
mod normal;
mod pass;
mod problem;
mod settings;
mod sums;
mod unfit;
mod window;

pub use estimates::{Estimates, Parameter};
pub use fit::Fit;
pub use problem::Problem;
pub use settings::{Prior, Settings, Starts};
pub use sums::cost_of_rms;
pub use unfit::Unfit;
pub use window::Recording;
