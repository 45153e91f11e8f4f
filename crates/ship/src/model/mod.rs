//! A surface vessel as data: the structure of its model, parameters and their constraints, channels,
//! actuators.
//!
//! States are surge `u`, sway `v` \[m/s\] and yaw rate `r` \[rad/s\] in body axes (x forward, y starboard, z down).
//! A model structure lists per degree of freedom terms that are products of powers and moduli of states, inputs and
//! measured disturbances; the parameter of a term multiplies it, and the sum is the state's increment per sample:
//! `x_d(k+1) = x_d(k) + φ_d(k)ᵀ θ_d`. See `docs/notation.md`. Or the model is made of forces in continuous time
//! ([`ForceModel`]), and has no terms per sample.

mod actuator;
mod at_bound;
mod equation;
mod file;
mod force_model;
mod formula;
mod gate;
mod physics;
mod rate_change;
mod similar;
mod structure;
mod term;
pub mod terms;

pub use crate::forces::TermSpec;
pub use actuator::{Actuator, ActuatorState, InputSpec, SampleCommand};
pub use equation::{Constrained, Constraint, Written};
pub use file::{Source, Vessel};
pub use force_model::ForceModel;
pub use formula::{DerivedChannel, DerivedSpec, Formula, Function, Malformed};
pub use physics::{Kind, MeasuredSpec, Unusual, VesselFile};
pub use rate_change::{ORDER, RateChange};
pub use structure::{Degree, DegreeOfFreedom, Model, ParameterLayout, Variable};
pub use term::{Factor, Product, Term};
