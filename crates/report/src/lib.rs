//! Figures as SVG, and two self-contained HTML pages about a study: to read, and to explore.
//!
//! A [`Study`] holds the results that exist; [`render`] shows them and says what is missing and which stage makes it.
//! The page has no script and no outside resource. [`explore`] makes the one with scripts, which sends no request either.
//! The same study gives the same bytes.

#![forbid(unsafe_code)]
#![warn(missing_docs)]

mod accuracy;
mod allocation;
mod averaged;
mod card;
mod certificate;
mod compared;
mod comparison;
mod crossval;
mod delivered;
mod derivatives;
mod designed_figures;
mod dictionary;
mod drawing;
mod errors;
mod estimators;
mod excitation;
mod explore;
pub mod figures;
mod headline;
mod histograms;
mod lacking;
mod load;
mod loader;
mod logs;
mod measured;
mod merit;
mod next_trial;
mod notes;
mod number;
mod page;
mod parameters;
mod parts;
mod picture;
mod plan_map;
mod planned_trial;
mod published_selection;
mod realizations;
mod residuals;
pub mod results;
mod sailed;
mod sample;
mod searched;
mod searched_forces;
mod selection;
mod sequential;
mod shown;
mod study;
mod table;
mod trajectory;
mod trust;
mod updated;
mod wrong;

pub use explore::explore;
pub use load::load;
pub use loader::Sources;
pub use measured::Measured;
pub use next_trial::NextTrial;
pub use page::{Rendered, render};
pub use parts::EXPLORE;
pub use picture::{maneuvers_picture, picture};
pub use plan_map::plan_map;
pub use planned_trial::PlannedTrial;
pub use selection::SelectionStudy;
pub use study::{ManeuverTrace, Scenario, Study, Trajectory};
