//! Simulated trials: undisturbed maneuvers, and many disturbed realizations of an experiment.

mod designed;
mod maneuvers;
mod realizations;
mod sea;
mod together;

pub use designed::{Designed, Parts, Plan, Tables, check_shares};
pub(crate) use designed::{drawable, shared_out};
pub use maneuvers::{Judged, LeftOut, Maneuvers, Reached, Tally, judge};
pub(crate) use realizations::even_lengths;
pub use realizations::{Campaign, Settings, random_segments};
pub use sea::{Group, OwnLoop, Refusal, Sea, SimulatedRun, States, Wanted};
pub(crate) use together::practice;
pub use together::{Experiment, Together};
