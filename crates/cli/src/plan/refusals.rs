//! Refusals of the other crates, with the file at fault and the flag that helps.

use std::fmt::Display;
use std::path::Path;

use crate::limits::mib_with_program;
use lattice::{Demand, NoPlan};
use refusal::{Invalid, nearest};
use seatrial::PlanError;
use trial::voyage::{Check, VoyageError};

use super::files::VoyageFiles;
use crate::failure::Failure;

/// Why there is no plan on a chart.
pub(super) fn plan(files: &VoyageFiles, error: PlanError) -> Failure {
    match error {
        PlanError::File(error) => error.into(),
        PlanError::Voyage(error) => voyage(files, error),
        PlanError::Unsafe(check) => unsafe_plan(files.config, &check),
    }
}

/// Why a trial on a chart cannot be planned.
fn voyage(files: &VoyageFiles, error: VoyageError) -> Failure {
    let config = files.config;
    match error {
        VoyageError::Invalid(invalid) => Failure::invalid(config, &invalid),
        VoyageError::UnknownManeuver { name, known } => {
            let near = nearest(&name, known.iter().map(String::as_str)).unwrap_or_default();
            let found = "a count without a maneuver of that name";
            let expected = format!("a maneuver of {}: {}", files.trajectories.display(), known.join(", "));
            let remedy = format!("did you mean `{near}`?");
            Failure::invalid(config, &Invalid::new(format!("maneuver `{name}`"), found, expected, remedy))
        }
        VoyageError::NoShare { maneuver, known } => Failure::refuse(
            files.design.unwrap_or(config),
            "`data.shares`",
            &format!("no share of maneuver `{maneuver}`"),
            &format!(
                "one of every maneuver without `count` in {}; it has {}",
                config.display(),
                known.join(", ")
            ),
            "make the design again from this dictionary, or give the maneuver a `count`",
        ),
        VoyageError::NoAnswer(invalid) => Failure::NoAnswer(format!("{}: {invalid}", config.display())),
        VoyageError::Infeasible(reason) => infeasible(config, &reason),
        VoyageError::OutOfTime(phase) => out_of_time(config, phase),
        VoyageError::TooLarge(footing) => does_not_fit(config, &footing, footing.bytes()),
        VoyageError::NoPlan(why) => no_plan(config, &why),
    }
}

/// The requirements that the check of a plan found violated.
fn unsafe_plan(config: &Path, check: &Check) -> Failure {
    let (least, margin) = (check.clearance_m.min(check.clearance_quantiles_m[0]), check.margin_m);
    Failure::NoAnswer(format!(
        "{}: plan at sea: found {}, least clearance {least:.0} m, expected at least {margin} m and ends \
         of legs within `approach` in every simulation; raise `safety.margin_m` or the tolerances, know the parameters better, or \
         take it labelled with --allow-unsafe",
        config.display(),
        check.faults.join(", ")
    ))
}

/// Why the search of the problem in `file` ended without a plan.
pub(super) fn no_plan(file: &Path, why: &NoPlan) -> Failure {
    match why {
        NoPlan::Infeasible(reason) => infeasible(file, &reason.to_string()),
        NoPlan::OutOfTime { lower_bound } => {
            let found = format!("none in time (any costs at least {})", lower_bound.primary);
            no_answer(file, &found, "raise --time-limit-s")
        }
        NoPlan::OutOfMemory { lower_bound } => {
            let found = format!("none in memory (any costs at least {})", lower_bound.primary);
            let remedy = "raise --memory-mib, or reduce counts, headings, speed modes or the lattice";
            no_answer(file, &found, remedy)
        }
        NoPlan::TooLarge { states, bytes } => {
            let found = format!("{states} states, which take {} MiB", mib_with_program(*bytes));
            let remedy = "raise --memory-mib, take --engine auto, or reduce counts, headings, speed modes or the lattice";
            no_answer(file, &found, remedy)
        }
    }
}

/// The time limit was reached in `phase`, before there was a checked plan.
pub(super) fn out_of_time(file: &Path, phase: &str) -> Failure {
    let remedy = "raise --time-limit-s, or reduce the lattice or `safety.runs`";
    no_answer(file, &format!("none in time, which ended in {phase}"), remedy)
}

/// A lattice too large to build.
pub(super) fn too_large(file: &Path, demand: &Demand) -> Failure {
    let Demand { poses, moves } = demand;
    does_not_fit(file, &format_args!("{poses} poses with up to {moves} moves"), demand.bytes())
}

fn does_not_fit(file: &Path, what: &dyn Display, bytes: u128) -> Failure {
    let remedy = "raise --memory-mib, or reduce the lattice, headings, speed modes or `raster_per_cell`";
    let found = format!("{what}, which take {} MiB", mib_with_program(bytes));
    Failure::NoAnswer(format!(
        "{}: plan: found {found}, expected at most --memory-mib; {remedy}",
        file.display()
    ))
}

fn infeasible(file: &Path, reason: &str) -> Failure {
    no_answer(file, &format!("none (proved): {reason}"), "change counts, map, start or goal")
}

fn no_answer(file: &Path, found: &str, remedy: &str) -> Failure {
    Failure::NoAnswer(format!("{}: plan: found {found}, expected one; {remedy}", file.display()))
}
