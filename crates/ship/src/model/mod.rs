//! A surface vessel as data: the structure of its model, parameters and their constraints, channels,
//! actuators.
//!
//! States are surge `u`, sway `v` \[m/s\] and yaw rate `r` \[rad/s\] in body axes (x forward, y starboard, z down).
//! A model structure lists per degree of freedom terms that are products of powers and moduli of states, inputs and
//! measured disturbances; the parameter of a term multiplies it, and the sum is the state's increment per sample:
//! `x_d(k+1) = x_d(k) + φ_d(k)ᵀ θ_d`. See `docs/notation.md`. Or the model is made of forces in continuous time
//! ([`ForceModel`]), and has no terms per sample.

mod acting;
mod actuator;
mod constraint;
mod derived;
mod equation;
mod file;
mod formula;
mod gate;
mod held;
mod input;
mod layout;
mod more_channels;
mod moved;
mod pace;
mod parts;
mod physics;
mod presets;
mod rate;
mod rows;
mod similar;
mod structure;
mod term;
pub mod terms;
mod written;

pub use crate::forces::TermSpec;
pub use acting::{ActuatorState, SampleCommand};
pub use actuator::Actuator;
pub use constraint::{Constrained, Constraint, Written};
pub use derived::{DerivedChannel, DerivedSpec};
pub use file::{Source, Vessel};
pub use formula::{Formula, Function, Malformed};
pub use input::InputSpec;
pub use layout::ParameterLayout;
pub use moved::ForceModel;
pub use pace::{ORDER, RateChange};
pub use structure::{Degree, DegreeOfFreedom, Model, Variable};
pub use term::{Factor, Product, Term};
pub use written::{Kind, MeasuredSpec, Unusual, VesselFile};
