//! A plan on a chart: the task in `plan.toml`, and the files of the plan.

mod cells;
mod charts;
mod check;
mod document;
mod exchange_set;
mod file;
mod follow;
mod task;

use std::fmt::Display;
use std::path::Path;

use files::Error;
use plan::lattice::{Demand, NoPlan};
use plan::voyage::{Check, VoyageError};
use refusal::nearest;

// Types of routes.
pub use chart::Plane;
pub use chart::route::{Feature, Geometry, Route};

pub use charts::{Charts, ChartsError, Means, chart_text, read_charts};
pub use document::{NamedFile, Routes, map_of, of_problem, of_voyage};
pub use file::{
    ApproachSpec, AreaSpec, ChartKind, ChartSpec, KnownCurrent, PlanFile, SensorSpec, SlotSpec, TideSpec,
    TrafficSpec,
};
pub use follow::{
    Begun, FollowError, FollowFiles, FollowedPlan, SoFar, read_begun, resumed, stated_place as place,
};
pub use task::{in_tide, programs, second, uncertain};

/// Why there is no plan, in one line.
#[derive(Debug)]
pub enum Unplanned {
    /// A file is refused.
    File(Error),
    /// There is none, or none was found.
    NoAnswer(String),
}

impl From<Error> for Unplanned {
    fn from(error: Error) -> Self {
        Self::File(error)
    }
}

/// Why a trial cannot be planned that `config` states and the runs in `trajectories` and `design` serve.
pub fn unplanned([config, trajectories]: [&Path; 2], design: Option<&Path>, error: VoyageError) -> Unplanned {
    match error {
        VoyageError::Invalid(invalid) => Error::invalid(config, invalid).into(),
        VoyageError::UnknownManeuver { name, known } => {
            let near = nearest(&name, known.iter().map(String::as_str)).unwrap_or_default();
            let given = "a count without a maneuver of that name";
            let expected = format!("a maneuver of {}: {}", trajectories.display(), known.join(", "));
            let remedy = format!("did you mean `{near}`?");
            Error::refuse(config, format!("maneuver `{name}`"), given, expected, remedy).into()
        }
        VoyageError::NoShare { maneuver, known } => Error::refuse(
            design.unwrap_or(config),
            "`data.shares`",
            format!("no share of maneuver `{maneuver}`"),
            format!(
                "one of every maneuver without `count` in {}; it has {}",
                config.display(),
                known.join(", ")
            ),
            "make the design again from this dictionary, or give the maneuver a `count`",
        )
        .into(),
        VoyageError::NoAnswer(invalid) => Unplanned::NoAnswer(format!("{}: {invalid}", config.display())),
        VoyageError::Infeasible(reason) => infeasible(config, &reason),
        VoyageError::OutOfTime(phase) => out_of_time(config, phase),
        VoyageError::TooLarge(footing) => does_not_fit(config, &footing, footing.bytes()),
        VoyageError::NoPlan(why) => no_plan(config, &why),
    }
}

/// The requirements that the check of a plan found violated.
pub fn unsafe_plan(config: &Path, check: &Check) -> Unplanned {
    let (least, margin) = (check.clearance_m.min(check.clearance_quantiles_m[0]), check.margin_m);
    Unplanned::NoAnswer(format!(
        "{}: plan at sea: found {}, least clearance {least:.0} m, expected at least {margin} m and ends \
         of legs within `approach` in every simulation; raise `safety.margin_m` or the tolerances, know the parameters better, or \
         take it labelled with --allow=unsafe",
        config.display(),
        check.faults.join(", ")
    ))
}

/// Why the search of the problem in `file` ended without a plan.
pub fn no_plan(file: &Path, why: &NoPlan) -> Unplanned {
    match why {
        NoPlan::Infeasible(reason) => infeasible(file, &reason.to_string()),
        NoPlan::OutOfTime { lower_bound } => {
            let answer = format!("none in time (any costs at least {})", lower_bound.primary);
            no_answer(file, &answer, "raise --time-limit-s")
        }
        NoPlan::OutOfMemory { lower_bound } => {
            let remedy = "raise --memory-mib, or reduce counts, headings, speed modes or the lattice";
            no_answer(file, &format!("none in memory (any costs at least {})", lower_bound.primary), remedy)
        }
        NoPlan::TooLarge { states, bytes } => {
            let answer = format!("{states} states, which take {} MiB", files::mib_with_program(*bytes));
            let remedy = "raise --memory-mib, or reduce counts, headings, speed modes or the lattice";
            no_answer(file, &answer, remedy)
        }
    }
}

/// The time limit was reached in `phase`, before there was a checked plan.
pub fn out_of_time(file: &Path, phase: &str) -> Unplanned {
    let remedy = "raise --time-limit-s, or reduce the lattice or `safety.runs`";
    no_answer(file, &format!("none in time, which ended in {phase}"), remedy)
}

/// A lattice too large to build.
pub fn too_large(file: &Path, demand: &Demand) -> Unplanned {
    let Demand { poses, moves } = demand;
    does_not_fit(file, &format_args!("{poses} poses with up to {moves} moves"), demand.bytes())
}

fn does_not_fit(file: &Path, what: &dyn Display, bytes: u128) -> Unplanned {
    let remedy = "raise --memory-mib, or reduce the lattice, headings, speed modes or `raster_per_cell`";
    let demand = format!("{what}, which take {} MiB", files::mib_with_program(bytes));
    Unplanned::NoAnswer(format!(
        "{}: plan: found {demand}, expected at most --memory-mib; {remedy}",
        file.display()
    ))
}

fn infeasible(file: &Path, reason: &str) -> Unplanned {
    no_answer(file, &format!("none (proved): {reason}"), "change counts, map, start or goal")
}

fn no_answer(file: &Path, found: &str, remedy: &str) -> Unplanned {
    Unplanned::NoAnswer(format!("{}: plan: found {found}, expected one; {remedy}", file.display()))
}
