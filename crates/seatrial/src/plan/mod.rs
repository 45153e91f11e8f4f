//! `plan`: from a design to a trajectory on a chart.

mod files;
mod problem;
mod refusals;
mod voyage;

pub use files::{MAIN, Resumed, VoyageFiles};
pub use frame::limits::Limits;
pub use problem::plan_problem;
pub use voyage::{Wanted, plan_voyage};
