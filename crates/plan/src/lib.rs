//! A trial on a chart: legs under an autopilot, the lattice and its search, the plan and its check at sea.
//!
//! Positions are metres east and north of the chart's origin, headings clockwise from north.

#![forbid(unsafe_code)]
#![warn(missing_docs)]

// Shared test code names the crate from outside.
#[cfg(test)]
extern crate self as plan;

mod autopilot;
mod basic;
mod deviations;
mod farthest;
mod grid;
mod handling;
mod informative;
mod inversion;
pub mod lattice;
mod leg;
mod navigation;
mod repertoire;
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
pub use repertoire::{Approach, Farthest, Outcome, Repertoire, Settled, Unsettled};
pub use sampled_vessel::SampledVessel;
pub use simulate::{End, Fix, Passing, Sailed, Sample, Stopped, simulate_legs};
pub use symmetry::mirror;
pub use tolerance::{Astray, Tolerance, Used};
