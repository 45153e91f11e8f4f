//! `plan`: from a design to a trajectory on a chart.

mod chart_layers;
mod check;
mod config;
mod counts;
mod information;
mod legs;
mod map;
mod moves;
mod outputs;
mod places;
mod problem;
mod ranges;
mod sailing;
mod search;
mod solve;
mod track;
mod trial;
mod voyage;
mod waters;

pub use config::PlanFile;
pub use problem::plan_problem;
pub use search::Limits;
pub use track::{TRACK, TRACK_VERSION, Track, read_planned, read_track};
pub use trial::VoyageFiles;
pub use voyage::plan_voyage;
