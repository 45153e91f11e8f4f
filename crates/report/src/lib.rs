//! Figures as SVG, and a self-contained HTML page about a study.
//!
//! A [`Study`] holds the results that exist; [`render`] shows them and says what is missing and which stage makes it.
//! Without scripts the page has all figures and tables; with them, some figures are there to zoom, filter and sort. It
//! sends no request. The same study gives the same bytes.

#![forbid(unsafe_code)]
#![warn(missing_docs)]

mod allocation;
mod compared;
mod comparison;
mod delivered;
mod dictionary;
mod estimators;
pub mod figures;
mod headline;
mod interactive;
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

pub use loader::Sources;
pub use measured::MeasuredStudy;
pub use merit::{maneuvers_picture, picture};
pub use next_trial::NextTrial;
pub use page::{Rendered, render};
pub use planned_trial::{PlannedTrial, plan_map};
pub use selection::SelectionStudy;
pub use study::{ManeuverTrace, Scenario, Study, Trajectory, load};
