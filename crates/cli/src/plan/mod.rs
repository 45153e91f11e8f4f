//! `plan`: from a design to a trajectory on a chart.

mod files;
mod problem;
mod refusals;
mod voyage;

pub use crate::limits::Limits;
pub use files::{MAIN, VoyageFiles};
pub use problem::plan_problem;
pub use voyage::{Wanted, plan_voyage};
