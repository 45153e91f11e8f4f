//! Why there is no plan, as failures of the program.

use std::path::Path;

use seatrial::PlanError;
use study::plan::{Unplanned, unplanned, unsafe_plan};

use crate::failure::Failure;

/// Why there is no plan of `plan.toml`, for the runs in `trajectories` and a design.
pub(super) fn plan(paths: [&Path; 2], design: Option<&Path>, error: PlanError) -> Failure {
    match error {
        PlanError::File(error) => error.into(),
        PlanError::Voyage(error) => unplanned(paths, design, error).into(),
        PlanError::Unsafe(check) => unsafe_plan(paths[0], &check).into(),
    }
}

impl From<Unplanned> for Failure {
    fn from(why: Unplanned) -> Self {
        match why {
            Unplanned::File(error) => error.into(),
            Unplanned::NoAnswer(message) => Self::NoAnswer(message),
        }
    }
}
