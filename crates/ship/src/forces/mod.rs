//! The forces on a ship in continuous time, as naval architects write them: hydrodynamic derivatives, propellers, rudders,
//! thrusters, wind and cross-flow drag.
//!
//! States are surge `u`, sway `v` \[m/s\] and yaw rate `r` \[rad/s\] relative to the water, in body axes (x forward, y
//! starboard, z down), about the origin amidships. A [`Description`] is checked and compiled to [`Forces`], which have one
//! flat vector θ of free parameters. [`Forces::body`] takes θ and gives a [`Body`]: its accelerations, and its steps by
//! Runge and Kutta's method of order 4. All of it is generic in the number: values, lanes, tangents ([`Dual`]).

mod body;
mod channels;
mod compiled;
mod components;
mod crossflow;
mod delays;
mod dimension;
mod dual;
mod gate;
pub mod grammar;
mod guess;
mod lateral;
mod mass;
mod number;
mod numbers;
mod parameter;
mod propeller;
mod quantity;
mod real;
mod rudder;
mod similar;
mod slots;
mod spec;
mod term;
mod thruster;
mod usual;
mod wind;

pub use body::Body;
pub use channels::{Channel, Driven};
pub use compiled::Forces;
pub use delays::late;
pub use dual::Dual;
pub use guess::{GRAVITY, Guess, MainDimensions, usual_froude};
pub use lateral::LateralSum;
pub use number::{Number, NumberSpec};
pub use parameter::Parameter;
pub use quantity::{Quantity, QuantitySource};
pub use real::Real;
pub use similar::Similarity;
pub use spec::{
    AddedMass, Area, Coriolis, CrossflowSpec, Curve, Description, Inflow, PropellerSpec, Reversed,
    RudderSpec, ShipSpec, TermSpec, ThrusterSpec, WindSpec,
};
pub use term::{Factor, LEAST_SQUARE, MOTION};
