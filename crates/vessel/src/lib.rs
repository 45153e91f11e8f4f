//! A surface vessel as data: model structure, parameters, maneuvers, disturbances, simulation.
//!
//! States are surge `u`, sway `v` \[m/s\] and yaw rate `r` \[rad/s\] in body axes (x forward, y starboard, z down).
//! A model structure lists per degree of freedom terms that are products of powers and moduli of states, inputs and
//! measured disturbances; the parameter of a term multiplies it, and the sum is the state's increment per sample:
//! `x_d(k+1) = x_d(k) + φ_d(k)ᵀ θ_d`. See `docs/notation.md`.

#![forbid(unsafe_code)]
#![warn(missing_docs)]

mod actuator;
mod compiled;
mod constraint;
mod derived;
mod disturbance;
mod equation;
mod file;
mod formula;
mod held;
mod lane;
pub mod lanes;
mod layout;
mod maneuver;
mod model;
mod more_channels;
mod newton;
mod noise;
mod normals;
mod pose;
mod products;
mod refusals;
mod rows;
mod run;
mod simulate;
mod steady;
mod term;
#[doc(hidden)]
pub mod vectorized;
mod wide;

pub use actuator::Actuator;
pub use compiled::{Ambient, Compiled};
pub use constraint::{Constrained, Constraint, Written};
pub use derived::{DerivedChannel, DerivedSpec};
pub use disturbance::{
    Axes, Current, Disturbances, Disturbing, MOST_CURRENT_M_S, Measurement, Weather, Wind, check_currents,
};
pub use equation::TermSpec;
pub use file::{InputSpec, MeasuredSpec, Source, Vessel, VesselFile};
pub use formula::{Formula, Function, Malformed};
pub use lane::{Arithmetic, LANES, Lane, Number, Numbers, Row};
pub use layout::ParameterLayout;
pub use maneuver::{
    CandidateKind, DictionaryFile, Exceeded, GenerateSpec, Generator, InputTable, Kept, Kind, Limits,
    ManeuverSpec, Pace, PlayedTable, Realized, Shape, Signal, SignalShape,
};
pub use model::{Degree, DegreeOfFreedom, Model, Variable};
pub use noise::Streams;
pub use pose::{Pose, track};
pub use refusal::{Invalid, check_numbers, choices, nearest};
pub use refusals::{MOST_SAMPLES, refuse_endless};
pub use run::{Run, RunView, Segment};
pub use simulate::{
    DIVERGED, Diverged, Driven, Recording, check_diverged, diverged_lanes, simulate, simulate_disturbed,
    simulate_groups, simulate_one,
};
pub use steady::{Motion, Steady};
pub use term::{Factor, Product, Term};
pub use wide::{GROUPS, Wide};
