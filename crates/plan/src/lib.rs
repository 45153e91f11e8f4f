//! A trial on a chart: legs under an autopilot, the lattice and its search, the plan and its check at sea.
//!
//! Positions are metres east and north of the chart's origin, headings clockwise from north.

#![forbid(unsafe_code)]
#![warn(missing_docs)]

// Shared test code names the crate from outside.
#[cfg(test)]
extern crate self as plan;

mod autopilot;
mod handling;
mod informative;
pub mod lattice;
mod leg;
mod repertoire;
mod sampled_vessel;
mod simulate;
pub mod voyage;

pub use autopilot::Autopilot;
pub use handling::{Ability, BASIC_MOVES, DerivedHandling, Handling, StatedHandling, basic_moves};
pub use leg::{Fixed, Grid, Leg, Mode, Navigation, Phase, Purpose, Sensors, Side, mirror};
pub use repertoire::{Approach, Farthest, Outcome, Repertoire, Settled, Unsettled};
pub use sampled_vessel::{Candidate, Deviations, Doubt, NotPositive, SampledVessel};
pub use simulate::{Astray, End, Fix, Passing, Sailed, Sample, Stopped, Tolerance, Used, simulate_legs};
