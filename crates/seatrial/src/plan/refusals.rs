//! What the science refuses, with the file that it stands in and the flag that helps.

use std::path::Path;

use lattice::NoPlan;
use trial::voyage::VoyageError;
use vessel::{Invalid, nearest};

use super::files::VoyageFiles;
use crate::failure::Failure;

/// Why a trial on a chart cannot be planned.
pub(super) fn voyage(files: &VoyageFiles, error: VoyageError) -> Failure {
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
        VoyageError::NoPlan(why) => no_plan(config, &why),
    }
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
            let found = format!("{states} states, which take {} MiB", bytes.div_ceil(1 << 20));
            let remedy = "raise --memory-mib, take --engine auto, or reduce counts, headings, speed modes or the lattice";
            no_answer(file, &found, remedy)
        }
    }
}

fn infeasible(file: &Path, reason: &str) -> Failure {
    no_answer(file, &format!("none (proved): {reason}"), "change counts, map, start or goal")
}

fn no_answer(file: &Path, found: &str, remedy: &str) -> Failure {
    Failure::NoAnswer(format!("{}: plan: found {found}, expected a feasible plan; {remedy}", file.display()))
}
