//! What disturbs runs of which nobody stated it: its kind and levels, by their restricted likelihood.
//!
//! The model is made linear about a path that looks back only: first the free simulation, then the filtered states. Errors and
//! sensitivities are columns of one linear filter, so the likelihood of what no parameter explains does not depend on them.
//! Noise and parameters are found in turns until these rest.

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
