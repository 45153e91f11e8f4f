//! `plan.json` of a plan.

use std::collections::BTreeMap;

use chart::Uncharted;
use plan::lattice::{Pose, Problem, Solution, Status, Step};
use plan::voyage::{Check, Prepared, SailedPlan, Solved};

use crate::documents::{
    CostUnit, DroppedMove, PlanDocument, PlanHandling, PlanLattice, PlanPose, PlanStatus, PlanStep,
    SecondaryCost, Voyage,
};

/// The plan of a lattice problem.
pub fn of_problem(problem: &Problem, solution: &Solution) -> PlanDocument {
    let pose = |p: Pose| PlanPose { i: p.i as u64, j: p.j as u64, h: p.layer as u64, mode: None };
    plan(problem, solution, CostUnit::Cost, pose)
}

/// The plan of a trial on a chart, as simulated.
pub fn of_voyage(voyage: &SailedPlan) -> PlanDocument {
    let SailedPlan { prepared, solved, sailing } = *voyage;
    let (grid, cost) = (&prepared.grid, prepared.brief.task.cost);
    let pose = |p: Pose| {
        let (level, mode) = grid.level_and_mode(p.layer);
        let mode = Some(grid.modes[mode].name.clone());
        PlanPose { i: p.i as u64, j: p.j as u64, h: level as u64, mode }
    };
    let Solved { problem, solution, .. } = solved;
    let planned = plan(problem, solution, cost.primary.into(), pose);
    PlanDocument {
        statement: labelled(planned.statement, &sailing.check),
        secondary: Some(SecondaryCost { name: cost.secondary, value: solution.cost.secondary }),
        voyage: Some(at_sea(voyage)),
        ..planned
    }
}

/// The statement on a plan, with the violations that its check found.
fn labelled(statement: String, check: &Check) -> String {
    match check.safe {
        true => statement,
        false => format!("{statement} Unsafe: {}.", check.faults.join(", ")),
    }
}

fn plan(
    problem: &Problem,
    solution: &Solution,
    cost_unit: CostUnit,
    pose: impl Fn(Pose) -> PlanPose,
) -> PlanDocument {
    let step = |s: &Step| PlanStep {
        action: problem.actions()[s.action].name.clone(),
        variant: s.variant as u64,
        from: pose(s.from),
        to: pose(s.to),
        cost: s.cost.primary,
    };
    let (status, statement) = status(problem, solution);
    PlanDocument {
        status,
        statement,
        cost_unit,
        cost: solution.cost.primary,
        lower_bound: solution.lower_bound.primary,
        gap: solution.gap(),
        secondary: None,
        counts: uses(problem, solution),
        steps: solution.steps.iter().map(step).collect(),
        voyage: None,
        charts: Vec::new(),
        beyond: Vec::new(),
    }
}

/// The status of the plan, also in words.
fn status(problem: &Problem, solution: &Solution) -> (PlanStatus, String) {
    match solution.status {
        Status::Optimal => {
            let states = problem.states();
            let statement = format!("Proved: no plan over the {states} states of the lattice costs less.");
            (PlanStatus::Optimal, statement)
        }
        Status::Feasible { .. } => (
            PlanStatus::Feasible,
            format!(
                "Not proved optimal: no plan costs less than {}, so this one is at most {} dearer than the best.",
                solution.lower_bound.primary,
                solution.gap()
            ),
        ),
    }
}

/// Uses of every informative action.
fn uses(problem: &Problem, solution: &Solution) -> BTreeMap<String, u64> {
    let used = |index: usize| solution.steps.iter().filter(|s| s.action == index).count() as u64;
    let informative = problem.actions().iter().enumerate().filter(|(_, action)| action.required > 0);
    informative.map(|(index, action)| (action.name.clone(), used(index))).collect()
}

fn at_sea(voyage: &SailedPlan) -> Voyage {
    let SailedPlan { prepared, solved, sailing } = *voyage;
    let samples = &sailing.sailed.samples;
    let (task, rate_hz) = (&prepared.brief.task, prepared.brief.vessel.sample_rate_hz);
    Voyage {
        lattice: lattice(prepared),
        legs: voyage.legs(),
        primitives: voyage.primitives(),
        dropped: dropped(prepared),
        handling: PlanHandling { used: task.handling, derived: task.derived },
        duration_s: samples.len() as f64 / rate_hz,
        informative_s: samples.iter().filter(|s| s.informative).count() as f64 / rate_hz,
        check: sailing.check.clone(),
        uncharted_share: prepared.uncharted_share(),
        uncharted_is_water: prepared.chart.uncharted() == Uncharted::Water,
        passage: voyage.passage(),
        information: sailing.information.clone(),
        front: solved.front.clone(),
    }
}

fn lattice(prepared: &Prepared) -> PlanLattice {
    let grid = &prepared.grid;
    let (longitude_deg, latitude_deg) = prepared.chart.plane().to_geographic(grid.origin_m);
    PlanLattice {
        nx: grid.nx as u64,
        ny: grid.ny as u64,
        headings: grid.headings as u64,
        cell_m: grid.cell_m,
        longitude_deg,
        latitude_deg,
        modes: grid.modes.iter().map(|m| (m.name.clone(), m.speed_m_s)).collect(),
    }
}

/// Moves that are not available to the search.
fn dropped(prepared: &Prepared) -> Vec<DroppedMove> {
    let grid = &prepared.grid;
    let dropped = prepared.dropped.iter().map(|own| {
        let (level, mode) = grid.level_and_mode(own.from);
        let (name, mode, why) = (own.name.clone(), grid.modes[mode].name.clone(), own.why.clone());
        DroppedMove { name, side: own.side, h: level as u64, mode, why }
    });
    dropped.collect()
}
