//! A surface vessel as data: the structure of its model, parameters and their constraints, channels, actuators.
//!
//! States are surge `u`, sway `v` \[m/s\] and yaw rate `r` \[rad/s\] in body axes (x forward, y starboard, z down).
//! A model structure lists per degree of freedom terms that are products of powers and moduli of states, inputs and
//! measured disturbances; the parameter of a term multiplies it, and the sum is the state's increment per sample:
//! `x_d(k+1) = x_d(k) + φ_d(k)ᵀ θ_d`. See `docs/notation.md`. Or the model is made of forces in continuous time
//! ([`ForceModel`]), and has no terms per sample.

mod actuator;
mod equation;
mod file;
mod formula;
mod physics;
mod structure;
mod term;
mod variants;

pub use crate::forces::TermSpec;
pub use actuator::{Actuator, ActuatorState, InputSpec, SampleCommand};
pub use equation::{Constrained, Constraint, Written};
pub use file::{Source, Vessel};
pub use formula::{ChannelRole, DerivedChannel, DerivedSpec, Formula, Function, Malformed};
pub use physics::{CandidateTerms, Kind, MeasuredSpec, Unusual, VesselFile};
pub use structure::{
    Degree, DegreeOfFreedom, ForceModel, Model, ORDER, ParameterLayout, RateChange, Variable,
};
pub use term::{Factor, Product, Term};

/// Terms that are added to a model.
pub mod terms {
    pub use super::variants::{add, listed};
}
