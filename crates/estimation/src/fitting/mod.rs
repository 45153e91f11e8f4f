//! Force models fitted to recordings: output error with priors, and the errors of its estimates.
//!
//! A [`Problem`] has recordings cut into windows. Each window is simulated freely, by steps of order 4 with inputs linear
//! between samples. [`Problem::fit`] finds the free parameters θ and the state that each window starts from: they minimise
//! the mean over windows of Huber's function of the window's RMS error, plus what the priors hold against θ. Errors are
//! counted in standard deviations of the measured states. Derivatives are tangents of the steps, eight windows side by
//! side; windows are simulated in parallel and added in order, so that the result has the same bits for any number of
//! threads.
//!
//! Before a trial there is a [`SimulatedRun`]: its information about θ, and after it the most probable θ of a
//! [`MeasuredRun`] whose start and noise are known.

mod bounded;
mod criticism;
mod estimates;
mod fit;
mod information;
mod most_probable;
mod normal;
mod pass;
mod problem;
mod settings;
mod sums;
mod unfit;
mod window;

pub use criticism::{AbsentTerm, Channels, Criticism, LEVEL, LateInput, Lateness, Turn, TurnedSign};
pub use estimates::{Estimates, Parameter};
pub use fit::Fit;
pub use information::{PredictedErrors, RunInformation, SimulatedRun, Slopes, WhiteNoise};
pub use most_probable::MeasuredRun;
pub use problem::Problem;
pub use settings::{Inputs, Prior, Settings, Starts};
pub use sums::cost_of_rms;
pub use unfit::Unfit;
pub use window::Recording;
