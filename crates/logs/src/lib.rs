//! Measured channels to a vessel's trajectories: units, clocks, kinematics, sub-experiments, quality.
//!
//! Knows no files. Axes: earth x north, y east, heading `psi` clockwise from north; body x forward, y starboard, z down
//! (NED and FRD). Numbers are in SI units and radians once [`unit()`] has converted them.
//!
//! A recording is a set of [`Series`], one per channel, each with a clock of its own. [`assemble`] turns it into channels
//! on one clock; [`cut`] finds the sub-experiments; [`consistency`] and [`noise_std`] say how good the data are.
//!
//! The other way round, [`Allocation`] turns forces into thruster settings, and [`chain`] into what a ship's instruments
//! would have logged.

#![forbid(unsafe_code)]
#![warn(missing_docs)]

mod allocation;
mod angle;
mod assemble;
pub mod chain;
mod clock;
mod formula;
mod frame;
mod geodesy;
mod grid;
mod kinematics;
mod lever;
mod prepare;
mod quality;
mod segment;
mod series;
mod smoother;
mod thruster;
mod unit;

pub use allocation::{Allocation, Setting, Unreachable};
pub use angle::unwrap;
pub use assemble::{Assembled, Recipe, Unassembled, assemble};
pub use clock::{Backwards, NonMonotonic, Order, TimeUnit, order};
pub use formula::{Formula, Malformed};
pub use frame::{Body, Frame, Heading};
pub use geodesy::LocalPlane;
pub use grid::{Grid, Stretch, stretches};
pub use kinematics::{Method, body_velocity, euler};
pub use lever::Lever;
pub use prepare::{Channels, Conventions, KINEMATIC, prepare};
pub use quality::{Consistency, consistency, lag, noise_std};
pub use segment::{Cut, Part, SpeedClasses, cut, labelled, within};
pub use series::Series;
pub use smoother::{local_quadratic, window_samples};
pub use thruster::{Law, Thruster};
pub use unit::{UNITS, Unit, factor, unit};
