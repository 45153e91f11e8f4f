//! Sensitivities of simulated and predicted states to the unknowns: the common engine of estimates, their standard
//! errors, the information of experiments and its gradient.
//!
//! [`Dynamics`] advances the states sample by sample; [`sweep`] propagates forward sensitivities with them, and
//! [`backward`] adjoints ([`slopes`] a single one, if only the gradient of squared errors is needed). Both are
//! columns of lanes. Numbers `X` are [`numerics::Lane`]s for runs in lanes, each unknown in its own column; or `f64`
//! for a single run, with [`numerics::LANES`] unknowns in a column ([`unknowns::Unknowns`]).

mod adjoint;
mod columns;
mod dynamics;
mod information;
mod kalman;
mod levels;
mod products;
mod recordings;
mod slopes;
mod sweep;
mod unknowns;

pub(crate) use adjoint::{add_draws, add_start, backward};
pub(crate) use dynamics::{Dynamics, Local, Motion, current_of, vessel_state};
pub use information::{
    OutputInformation, Simulated, output_information, output_informations, prediction_weights,
};
pub(crate) use information::{RunInformation, channels};
pub(crate) use kalman::{Gain, add_noise, filter, filter_along, filter_each, gain, moved, shrink, start};
pub(crate) use levels::with_states;
pub use levels::{Drift, Flow, ForceNoise, NoiseModel};
pub(crate) use products::Products;
pub use recordings::Recordings;
pub(crate) use recordings::{groups, of_one_length};
pub use slopes::{Slopes, slopes};
pub(crate) use sweep::sweep;
pub use sweep::{Sensitivities, Step, free_sweep};
