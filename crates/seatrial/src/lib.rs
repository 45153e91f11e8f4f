//! seatrial in memory: plan a trial, simulate it, identify a ship's model.

#![forbid(unsafe_code)]
#![warn(missing_docs)]

mod monte_carlo;
mod simulation;

pub use identification::{Estimator, RunEstimate, RunScore};
pub use maneuver::DictionaryFile;
pub use model::Vessel;
pub use monte_carlo::{MonteCarlo, Realized};
pub use simulation::{Optimum, Study, StudyError, undisturbed};
pub use study::campaign_file::CampaignFile;
