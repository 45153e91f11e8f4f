//! The documents that the stages exchange, as they stand in the files.

mod design;
mod estimate;
mod moments;
mod reference;
mod validation;

pub use design::{Counts, DesignDocument, Efficiency, Start};
pub use estimate::{DegreeSummary, DesignSummary, EstimateDocument, ParameterSummary};
pub use moments::{DegreeMoments, DegreeStructure, ManeuverMoments, MomentsDocument};
pub use reference::{Published, PublishedShare, Reference};
pub use validation::{Bounds, DesignScores, Quantiles, ValidationDocument};
