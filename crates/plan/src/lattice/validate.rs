//! The conditions on a problem. After this nothing is checked twice.

use std::collections::BTreeSet;

use crate::lattice::{Action, Cost, Goal, Invalid, Lattice, Move, Pose};

/// Most uses of all informative actions together, so that sums of keys and prices stay in range.
const MOST_USES: u64 = 100_000;
/// Bits for the counts of one state.
const COUNT_BITS: u32 = 128;

pub(crate) fn lattice(lattice: &Lattice) -> Result<(), Invalid> {
    let found = format!("{} x {} cells, {} layers", lattice.nx, lattice.ny, lattice.layers);
    let poses = lattice.nx.checked_mul(lattice.ny).and_then(|cells| cells.checked_mul(lattice.layers));
    match poses {
        Some(0) => Err(Invalid::new("lattice", found, "at least one cell and one layer", "give its size")),
        Some(poses) if u32::try_from(poses).is_ok_and(|poses| poses < u32::MAX) => Ok(()),
        _ => Err(Invalid::new("lattice", found, "fewer than 2^32 poses", "take larger cells")),
    }
}

pub(crate) fn actions(lattice: &Lattice, actions: &[Action]) -> Result<(), Invalid> {
    let mut names = BTreeSet::new();
    for action in actions {
        let thing = || format!("action {}", action.name);
        if !names.insert(&action.name) {
            return Err(Invalid::new(thing(), "this name twice", "unique names", "rename one of them"));
        }
        if action.required > 0 && action.moves.is_empty() {
            let expected = "moves, since it must be used";
            return Err(Invalid::new(thing(), "no moves", expected, "give it moves or leave it out"));
        }
        for (index, step) in action.moves.iter().enumerate() {
            self::step(lattice, &format!("action {}, move {index}", action.name), step)?;
        }
    }
    uses(actions)
}

fn step(lattice: &Lattice, thing: &str, step: &Move) -> Result<(), Invalid> {
    for (side, layer) in [("from", step.from), ("to", step.to)] {
        if layer >= lattice.layers {
            let expected = format!("less than {}", lattice.layers);
            let remedy = "layers count from 0";
            return Err(Invalid::new(format!("{thing}, {side} layer"), layer.to_string(), expected, remedy));
        }
    }
    cost(thing, step.cost)
}

fn cost(thing: &str, cost: Cost) -> Result<(), Invalid> {
    for (criterion, value) in [("primary", cost.primary), ("secondary", cost.secondary)] {
        if !(value.is_finite() && value >= 0.0) {
            let thing = format!("{thing}, {criterion} cost");
            let expected = "a finite number not below 0";
            return Err(Invalid::new(thing, value.to_string(), expected, "a shortest plan needs such costs"));
        }
    }
    Ok(())
}

fn uses(actions: &[Action]) -> Result<(), Invalid> {
    let total: u64 = actions.iter().map(|action| u64::from(action.required)).sum();
    if total > MOST_USES {
        let expected = format!("at most {MOST_USES}");
        return Err(Invalid::new(
            "required uses in total",
            total.to_string(),
            expected,
            "take longer maneuvers",
        ));
    }
    let bits: u32 = actions.iter().map(|action| u32::BITS - action.required.leading_zeros()).sum();
    if bits > COUNT_BITS {
        let expected = format!("counts of all informative actions within {COUNT_BITS} bits");
        return Err(Invalid::new(
            "required uses",
            format!("{bits} bits"),
            expected,
            "take fewer or longer maneuvers",
        ));
    }
    Ok(())
}

pub(crate) fn ends(lattice: &Lattice, start: Pose, goal: &Goal) -> Result<(), Invalid> {
    let inside = |thing: &str, pose: Pose| {
        let expected = format!("below ({}, {}, {})", lattice.nx, lattice.ny, lattice.layers);
        let outside =
            || Invalid::new(thing, pose.to_string(), expected, "give a pose (i, j, layer) of the lattice");
        if lattice.contains(pose) { Ok(()) } else { Err(outside()) }
    };
    inside("start", start)?;
    match goal {
        Goal::Any => Ok(()),
        Goal::Poses(poses) if poses.is_empty() => Err(Invalid::new(
            "goal",
            "no pose",
            "at least one pose",
            "list poses, or let the plan end anywhere",
        )),
        Goal::Poses(poses) => poses.iter().try_for_each(|&pose| inside("goal", pose)),
    }
}

pub(crate) fn arcs(count: usize) -> Result<(), Invalid> {
    let too_many = |_| {
        Invalid::new(
            "allowed moves",
            count.to_string(),
            "fewer than 2^32 over all poses",
            "take larger cells",
        )
    };
    u32::try_from(count).map(|_| ()).map_err(too_many)
}
