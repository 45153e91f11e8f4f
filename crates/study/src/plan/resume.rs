//! The rest of a plan, from the ship's position.

use std::collections::BTreeMap;
use std::path::Path;

use files::{Error, Provenance, read_document};
use plan::voyage::{Goal, ManeuverUse, Place, Task};
use refusal::Invalid;

use crate::documents::{PlanDocument, PlanStep};

/// `LONGITUDE,LATITUDE,HEADING` or `LONGITUDE,LATITUDE,HEADING,MODE`, in degrees.
///
/// # Errors
/// Another text, in words.
pub fn place(text: &str) -> Result<Place, String> {
    let cells: Vec<&str> = text.split(',').map(str::trim).collect();
    let number = |cell: &str| cell.parse::<f64>().ok().filter(|value| value.is_finite());
    let refused = || {
        format!(
            "found `{text}`, expected LONGITUDE,LATITUDE,HEADING[,MODE] in degrees, such as 24.95,60.15,45,half"
        )
    };
    let (numbers, mode) = match cells.len() {
        3 => (&cells[..], None),
        4 => (&cells[..3], Some(cells[3].to_owned())),
        _ => return Err(refused()),
    };
    let numbers: Option<Vec<f64>> = numbers.iter().map(|cell| number(cell)).collect();
    let numbers = numbers.ok_or_else(refused)?;
    Ok(Place { longitude_deg: numbers[0], latitude_deg: numbers[1], heading_deg: numbers[2], mode })
}

/// Reads the plan at `path`, which was begun. With a model in the vessel's place (`of_model`), it may be a plan for another
/// vessel: for the one of before the trial.
///
/// # Errors
/// A file that is refused.
pub fn read_begun(path: &Path, of_model: bool, provenance: &mut Provenance) -> Result<PlanDocument, Error> {
    let loaded = read_document::<PlanDocument>(path)?;
    match of_model {
        true => provenance.written("plan", path, loaded.digest)?,
        false => provenance.made("plan", path, loaded.digest, &loaded.provenance)?,
    }
    Ok(loaded.data)
}

/// The rest of `task` after the first `done` steps of its `plan`, with the ship at `from`, which becomes a node of
/// the lattice. Home stays the start of the whole trial.
///
/// # Errors
/// More steps than the plan has; a finished plan.
pub fn resumed(task: Task, plan: &PlanDocument, done: usize, from: Place) -> Result<Task, Invalid> {
    if done > plan.steps.len() {
        let expected = format!("at most {}, the steps of the plan", plan.steps.len());
        return Err(Invalid::new("`--done`", done.to_string(), expected, "count the steps that are done"));
    }
    rest_of(task, plan, &plan.steps[..done], from).ok_or_else(|| {
        let found = format!("every maneuver among the first {done} steps");
        let remedy = "sail the plan to its end, or count the steps again";
        Invalid::new("`--done`", found, "a maneuver that is left to do", remedy)
    })
}

/// The rest of `task` after the `done` steps of its `plan`, as [`resumed`] has it; `None` where no maneuver is left.
pub(super) fn rest_of<'a>(
    mut task: Task,
    plan: &PlanDocument,
    done: impl IntoIterator<Item = &'a PlanStep>,
    from: Place,
) -> Option<Task> {
    let mut left: BTreeMap<&str, u64> =
        plan.counts.iter().map(|(name, count)| (name.as_str(), *count)).collect();
    for step in done {
        if let Some(count) = left.get_mut(step.action.as_str()) {
            *count = count.saturating_sub(1);
        }
    }
    left.retain(|_, count| *count > 0);
    if left.is_empty() {
        return None;
    }
    task.maneuvers = maneuvers(&task, left);
    if matches!(task.goal, Goal::Home {}) {
        task.goal = Goal::Places { places: vec![task.start] };
    }
    task.on_node = true;
    task.start = from;
    Some(task)
}

/// Uses of maneuvers, in pieces as `task` has them.
pub(super) fn maneuvers<'a>(
    task: &Task,
    counts: impl IntoIterator<Item = (&'a str, u64)>,
) -> Vec<ManeuverUse> {
    let of = |(name, count): (&str, u64)| {
        let known = task.maneuvers.iter().find(|own| own.name == name);
        ManeuverUse {
            name: name.to_owned(),
            count: Some(count.min(u64::from(u32::MAX)) as u32),
            piece_s: known.and_then(|own| own.piece_s),
        }
    };
    counts.into_iter().map(of).collect()
}
