//! Figures as SVG, and two self-contained HTML pages about a study: to read, and to explore.
//!
//! A [`Study`] holds the results that exist; [`render`] shows them and says what is missing and which stage makes it.
//! The page has no script and no outside resource. [`explore`] makes the one with scripts, which sends no request either.
//! The same study gives the same bytes.

#![forbid(unsafe_code)]
#![warn(missing_docs)]

mod allocation;
mod compared;
mod comparison;
mod delivered;
mod dictionary;
mod estimators;
mod explore;
pub mod figures;
mod headline;
mod loader;
mod measured;
mod merit;
mod next_trial;
mod number;
mod page;
mod parts;
mod planned_trial;
pub mod results;
mod searched;
mod selection;
mod sequential;
mod study;
mod trajectory;
mod trust;

pub use explore::explore;
pub use loader::Sources;
pub use measured::MeasuredStudy;
pub use merit::{maneuvers_picture, picture};
pub use next_trial::NextTrial;
pub use page::{Rendered, render};
pub use parts::EXPLORE;
pub use planned_trial::{PlannedTrial, plan_map};
pub use selection::SelectionStudy;
pub use study::{ManeuverTrace, Scenario, Study, Trajectory, load};
