use crate::lattice::graph::{Graph, Reach, within};
use crate::lattice::layered::Levels;
use crate::lattice::watch::{Verdict, Watch};
use crate::lattice::{
    Cost, Limit, NoPlan, Options, Problem, Progress, Reason, Solution, Status, Step, beam, dense, layered,
    reason,
};

/// Keys of plans around start and goals that are searched first, in keys of the dearest move.
const NEAREST: u64 = 8;
/// The surroundings are searched first while the lattice is so many times as large.
const PART: usize = 3;

/// Finds the cheapest plan. `keep_going` is polled and cancels the search by returning false. If time or memory end
/// the search, a narrow beam finds a plan where that takes only a moment; it is returned with a lower bound.
///
/// # Errors
/// No plan: proved, or for lack of time or memory.
///
/// ```
/// use crate::lattice::{Action, Cost, Goal, Lattice, Move, Options, Pose, Problem, plan};
/// let east = |di, cost| Move { from: 0, di, dj: 0, to: 0, cost: Cost::primary(cost) };
/// let actions = vec![
///     Action { name: "zigzag".into(), required: 2, moves: vec![east(3, 0.0)] },
///     Action { name: "forward".into(), required: 0, moves: vec![east(1, 1.0)] },
/// ];
/// let pose = |i| Pose { i, j: 0, layer: 0 };
/// let lattice = Lattice { nx: 9, ny: 1, layers: 1 };
/// let problem = Problem::new(lattice, actions, pose(0), Goal::Poses(vec![pose(8)]), |_, _, _| true)?;
/// let solution = plan(&problem, &Options::default(), &mut |_| true).expect("four steps east");
/// assert_eq!((solution.cost.primary, solution.steps.len()), (2.0, 4));
/// # Ok::<(), crate::lattice::Invalid>(())
/// ```
pub fn plan(
    problem: &Problem,
    options: &Options,
    keep_going: &mut dyn FnMut(Progress) -> bool,
) -> Result<Solution, NoPlan> {
    let mut watch = Watch::new(problem, options.poll_every, keep_going);
    let out_of_time = NoPlan::OutOfTime { lower_bound: problem.cost(0, &problem.required()) };
    let Some(reach) = Reach::new(problem, &mut watch) else { return Err(out_of_time) };
    if let Some(reason) = reason::from_map(problem, &reach) {
        return Err(NoPlan::Infeasible(reason));
    }
    let Some(graph) = Graph::new(problem, &reach.live(), &mut watch) else {
        // If the start does not reach the goal, the map has given a reason already.
        return Err(out_of_time);
    };
    let bytes = exhaustive_bytes(&graph);
    let verdict = if bytes <= u128::from(memory(&graph, options)) {
        nearest_first(&graph, options, &mut watch)
    } else {
        beam::glimpse(&graph, memory(&graph, options), watch.lower, Limit::Memory)
    };
    match outcome(problem, verdict) {
        Err(NoPlan::OutOfMemory { .. }) if bytes > u128::from(memory(&graph, options)) => {
            Err(NoPlan::TooLarge { states: graph.states(), bytes })
        }
        outcome => outcome,
    }
}

fn memory(graph: &Graph, options: &Options) -> u64 {
    options.memory_bytes.saturating_sub(graph.bytes())
}

/// Bytes that the exhaustive search needs.
pub(crate) fn exhaustive_bytes(graph: &Graph) -> u128 {
    match Levels::of(graph) {
        Some(levels) => layered::bytes(graph, levels),
        None if dense::fits(graph) => dense::bytes(graph),
        None => u128::MAX,
    }
}

/// The exhaustive search around start and goals first, as long as that is a small part of the lattice. What it finds there is optimal:
/// plans that leave it are dearer.
fn nearest_first(graph: &Graph, options: &Options, watch: &mut Watch) -> Verdict {
    let dearest = graph.problem.moves.iter().map(|step| step.key).max().unwrap_or(0);
    let mut most = NEAREST.saturating_mul(dearest);
    let whole = Levels::of(graph).is_some_and(|levels| !levels.are_partial());
    while !whole && (1..u64::MAX / 4).contains(&most) {
        let Ok(live) = within(graph.problem, most, memory(graph, options), watch) else { break };
        if PART * live.iter().filter(|live| **live).count() > graph.len() {
            break;
        }
        let near = Graph::new(graph.problem, &live, watch);
        drop(live);
        if let Some(near) = near {
            let memory = memory(graph, options).saturating_sub(near.bytes());
            let verdict = all_states(&near, most, memory, watch);
            if verdict.plan.is_some() {
                return verdict;
            }
            // What is larger takes even longer and more memory.
            if verdict.stopped_by.is_some() {
                break;
            }
        }
        most *= 2;
    }
    let verdict = all_states(graph, u64::MAX, memory(graph, options), watch);
    match verdict.stopped_by {
        Some(limit) if verdict.plan.is_none() => {
            beam::glimpse(graph, memory(graph, options), verdict.lower, limit)
        }
        _ => verdict,
    }
}

/// The cheapest plan with a key of at most `most`, by the exhaustive search that fits the costs.
fn all_states(graph: &Graph, most: u64, memory: u64, watch: &mut Watch) -> Verdict {
    match Levels::of(graph) {
        Some(levels) => layered::search(graph, levels, most, memory, watch),
        None => dense::search(graph, most, memory, watch),
    }
}

fn outcome(problem: &Problem, verdict: Verdict) -> Result<Solution, NoPlan> {
    let lower_bound = problem.cost(verdict.lower, &problem.required());
    match (verdict.plan, verdict.stopped_by) {
        (Some((_, walk)), stopped_by) => Ok(solution(problem, &walk, stopped_by, lower_bound)),
        (None, None) => {
            Err(NoPlan::Infeasible(Reason::CountsCannotBeCombined { possible: verdict.possible }))
        }
        (None, Some(Limit::Time)) => Err(NoPlan::OutOfTime { lower_bound }),
        (None, Some(Limit::Memory)) => Err(NoPlan::OutOfMemory { lower_bound }),
    }
}

/// Executes the moves from the start.
fn solution(problem: &Problem, walk: &[u32], stopped_by: Option<Limit>, lower_bound: Cost) -> Solution {
    let (mut from, mut cost) = (problem.start(), Cost::default());
    let mut steps = Vec::with_capacity(walk.len());
    for &step in walk {
        let known = &problem.moves[step as usize];
        let shape = &problem.actions()[known.id.action].moves[known.id.index];
        let Some(to) = problem.lattice().end(from, shape) else {
            unreachable!("the searches follow allowed moves, and those stay in the lattice")
        };
        let (action, variant) = (known.id.action, known.variant as usize);
        steps.push(Step { action, variant, from, to, cost: shape.cost });
        cost.primary += shape.cost.primary;
        cost.secondary += shape.cost.secondary;
        from = to;
    }
    match stopped_by {
        None => Solution { status: Status::Optimal, cost, lower_bound: cost, steps },
        Some(stopped_by) => Solution { status: Status::Feasible { stopped_by }, cost, lower_bound, steps },
    }
}
