//! The forces on a ship in continuous time, as naval architects write them: hydrodynamic derivatives, propellers, rudders,
//! thrusters, wind and cross-flow drag.
//!
//! States are surge `u`, sway `v` \[m/s\] and yaw rate `r` \[rad/s\] relative to the water, in body axes (x forward, y
//! starboard, z down), about the origin amidships. A [`Description`] is checked and compiled to [`Forces`], which have one
//! flat vector θ of free parameters. [`Forces::body`] takes θ and gives a [`Body`]: its accelerations, and its steps by
//! Runge and Kutta's method of order 4. All of it is generic in the number: values, lanes, tangents ([`Dual`]).

mod actuators;
mod body;
mod dual;
mod gate;
mod guess;
mod mass;
mod numbers;
mod slots;
mod spec;
mod term;
mod usual;

pub use body::{Body, Forces, LateralSum, late};
pub use dual::{Dual, Real};
pub use guess::{GRAVITY, Guess, MainDimensions, usual_froude};
pub use numbers::{Channel, Driven, Parameter, Quantity, QuantitySource};
pub use spec::{
    AddedMass, Area, Coriolis, CrossflowSpec, Curve, Description, Inflow, Number, NumberSpec, PropellerSpec,
    Reversed, RudderSpec, ShipSpec, TermSpec, ThrusterSpec, WindSpec,
};
pub use term::{Factor, LEAST_SQUARE, MOTION};
pub use usual::Similarity;

pub(crate) use term::{MOST_FACTORS, parse_name, parse_power};
