//! Simulated trials: undisturbed maneuvers, and many disturbed realizations of an experiment.

mod designed;
mod maneuvers;
mod own_loop;
mod plays;
mod practice;
mod realizations;
mod refusal;
mod sea;
mod tally;
mod together;

pub use designed::{Designed, Parts, check_shares};
pub use maneuvers::{Judged, Maneuvers, Reached, judge};
pub use own_loop::OwnLoop;
pub use plays::{Plan, Tables};
pub(crate) use plays::{drawable, shared_out};
pub(crate) use realizations::even_lengths;
pub use realizations::{Campaign, Settings, random_segments};
pub use refusal::Refusal;
pub use sea::{Group, Sea, SimulatedRun, States, Wanted};
pub use tally::{LeftOut, Tally};
pub use together::{Experiment, Together};
