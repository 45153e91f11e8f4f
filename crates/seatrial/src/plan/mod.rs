//! `plan`: from a design to a trajectory on a chart.

mod files;
mod limits;
mod problem;
mod refusals;
mod voyage;

pub use files::{MAIN, VoyageFiles};
pub use limits::Limits;
pub use problem::plan_problem;
pub use voyage::{Wanted, plan_voyage};
