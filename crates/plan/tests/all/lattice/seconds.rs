//! Secondary costs for laws and measurements.

use plan::lattice::{MoveId, Pose, Problem};

/// `problem` with other seconds for every move as the secondary cost.
pub fn with_seconds(problem: &Problem) -> Problem {
    let mut actions = problem.actions().to_vec();
    for (action, own) in actions.iter_mut().enumerate() {
        for (index, step) in own.moves.iter_mut().enumerate() {
            step.cost.secondary = (10 + (7 * action + 5 * index) % 23) as f64;
        }
    }
    let allowed = |id: MoveId, i, j| {
        let layer = problem.actions()[id.action].moves[id.index].from;
        problem.is_allowed(Pose { i, j, layer }, id)
    };
    Problem::new(problem.lattice(), actions, problem.start(), problem.goal().clone(), allowed)
        .expect("the same moves")
}
