//! Trials in rounds: design from current knowledge, run, estimate, design the next round; against designs
//! made once.

mod growing_run;
mod knowledge;
mod planner;
mod row;
mod stopping;
mod summary;
mod trial;

pub use growing_run::GrowingRun;
pub use knowledge::Knowledge;
pub use planner::{Planner, SoFar};
pub use row::{Arm, Outcome, Row, Shared};
pub use stopping::{RoundGain, Stopping};
pub use summary::{ArmPoint, ArmSummary, Summary};
pub use trial::{Trial, ends, truth};
