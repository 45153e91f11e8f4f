//! The kind and levels of the noise of runs that do not state it, by restricted likelihood.
//!
//! The model is linearised about a causal path: first the free simulation, then the filtered states. Errors and
//! sensitivities are columns of one linear filter, so the likelihood of the part that no parameter explains does not
//! depend on the parameters. Noise and parameters are found alternately until the parameters converge.

mod begin;
mod kind;
mod line;
mod pass;
mod search;
mod turns;

pub(crate) use kind::Guess;
pub use kind::NoiseKind;
pub(super) use kind::{LASTING, side_by_side};
pub(crate) use turns::{ENOUGH, Kinds};
pub(super) use turns::{Noise, Turns};
