//! From a vessel and its dictionary to moves on a lattice, and from a plan on the lattice back to sea.
//!
//! A [`Leg`] is a move of the lattice: a script of phases that an [`Autopilot`] carries out, with an
//! informative maneuver between a steady approach and a recovery onto the lattice. Poses are
//! north, east \[m\] and compass heading \[rad\]; the lattice counts headings counter-clockwise from east,
//! and only [`Grid`] converts.

#![forbid(unsafe_code)]
#![warn(missing_docs)]

pub mod arranging;
mod autopilot;
mod basic;
pub mod campaign;
mod deviations;
mod farthest;
mod grid;
mod handling;
mod informative;
mod inversion;
mod leg;
pub mod moments;
mod navigation;
mod piece;
pub mod refining;
mod repertoire;
pub mod rounds;
mod sampled_vessel;
mod simulate;
mod symmetry;
mod tolerance;
pub mod voyage;

pub use autopilot::Autopilot;
pub use basic::{BASIC_MOVES, basic_moves};
pub use deviations::{Candidate, Deviations, Doubt, NotPositive};
pub use grid::{Grid, Mode};
pub use handling::{Ability, DerivedHandling, Handling, StatedHandling};
pub use leg::{Leg, Phase, Purpose, Side};
pub use navigation::{Fixed, Navigation, Sensors};
pub use piece::{Piece, period};
pub use repertoire::{Approach, Farthest, Outcome, Repertoire, Settled, Unsettled};
pub use sampled_vessel::SampledVessel;
pub use simulate::{End, Fix, Passing, Sailed, Sample, Stopped, simulate_legs};
pub use symmetry::mirror;
pub use tolerance::{Astray, Tolerance, Used};
