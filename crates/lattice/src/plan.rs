use crate::graph::{Graph, Reach, within};
use crate::lagrangian::{self, Depth};
use crate::layered::Levels;
use crate::watch::{Verdict, Watch};
use crate::{
    Cost, Engine, Limit, NoPlan, Options, Problem, Progress, Reason, Solution, Status, Step, dense, layered,
    reason,
};

/// States up to which `Auto` searches exhaustively: all as bits, as bits and the optimal ones as distances, all as distances.
const LARGE_BITS: u128 = 20_000_000_000;
const LARGE_PARTIAL: u128 = LARGE_BITS / 3;
const LARGE_DENSE: u128 = 200_000_000;
/// States as bits up to which it does so without computing bounds first. Of others there are no more, and bounds seldom prove a
/// secondary cost.
const SMALL_BITS: u128 = 2_000_000_000;
/// Keys of plans around start and goals that are searched first, in keys of the dearest move.
const NEAREST: u64 = 8;
/// The surroundings are searched first while the lattice is so many times as large.
const PART: usize = 3;

/// Finds the cheapest plan. `keep_going` is polled and cancels the search by returning false; the best plan
/// by then is returned with a lower bound. If there is none yet, one narrow beam may still be searched after
/// that.
///
/// # Errors
/// No plan: proved, or for lack of time or memory.
///
/// ```
/// use lattice::{Action, Cost, Goal, Lattice, Move, Options, Pose, Problem, plan};
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
/// # Ok::<(), lattice::Invalid>(())
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
    match engine(&graph, options) {
        Chosen::TooLarge(bytes) => Err(NoPlan::TooLarge { states: graph.states(), bytes }),
        Chosen::Exhaustive => outcome(problem, nearest_first(&graph, options, &mut watch)),
        Chosen::BoundsFirst => outcome(problem, bounds_first(graph, options, &mut watch)),
        Chosen::Lagrangian => {
            outcome(problem, lagrangian::search(&graph, memory(&graph, options), Depth::Proof, &mut watch))
        }
    }
}

enum Chosen {
    Exhaustive,
    /// Exhaustive, after bounds and beams.
    BoundsFirst,
    Lagrangian,
    TooLarge(u128),
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

fn engine(graph: &Graph, options: &Options) -> Chosen {
    let (states, bytes) = (graph.states(), exhaustive_bytes(graph));
    let fits = bytes <= u128::from(memory(graph, options));
    let (small, large) = match Levels::of(graph) {
        Some(levels) if levels.are_partial() => (LARGE_PARTIAL, LARGE_PARTIAL),
        Some(_) => (SMALL_BITS, LARGE_BITS),
        None => (LARGE_DENSE, LARGE_DENSE),
    };
    match options.engine {
        Engine::Exhaustive if fits => Chosen::Exhaustive,
        Engine::Exhaustive => Chosen::TooLarge(bytes),
        Engine::Lagrangian => Chosen::Lagrangian,
        Engine::Auto if !fits || states > large => Chosen::Lagrangian,
        Engine::Auto if states <= small => Chosen::Exhaustive,
        Engine::Auto => Chosen::BoundsFirst,
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
    exhaustive(graph, u64::MAX, options, false, watch)
}

/// The cheapest plan with a key of at most `most`, by the exhaustive search that fits the costs.
fn all_states(graph: &Graph, most: u64, memory: u64, watch: &mut Watch) -> Verdict {
    match Levels::of(graph) {
        Some(levels) => layered::search(graph, levels, most, memory, watch),
        None => dense::search(graph, most, memory, watch),
    }
}

/// If it is cancelled without a plan, a narrow beam searches for one, provided that takes only a moment.
fn exhaustive(graph: &Graph, most: u64, options: &Options, has_plan: bool, watch: &mut Watch) -> Verdict {
    let memory = memory(graph, options);
    let verdict = all_states(graph, most, memory, watch);
    match verdict.stopped_by {
        Some(Limit::Memory) => lagrangian::search(graph, memory, Depth::Proof, watch),
        Some(Limit::Time) if !has_plan && lagrangian::is_glimpsed_at_once(graph) => {
            let plan =
                lagrangian::glimpse(graph, memory, &mut Watch::new(graph.problem, u64::MAX, &mut |_| true));
            Verdict::stopped(plan, verdict.lower, Limit::Time)
        }
        _ => verdict,
    }
}

/// Bounds and beams, and if they leave a gap the exhaustive search, where plans that are no dearer than the best of the beams pass.
pub(crate) fn bounds_first(graph: Graph, options: &Options, watch: &mut Watch) -> Verdict {
    let root = lagrangian::search(&graph, memory(&graph, options), Depth::Root, watch);
    if root.stopped_by.is_none() || !watch.keep_going(0) {
        return root;
    }
    let most = root.plan.as_ref().map_or(u64::MAX, |plan| plan.0);
    let graph = match &root.plan {
        None => Some(graph),
        Some(_) => {
            let problem = graph.problem;
            drop(graph);
            match within(problem, most, options.memory_bytes, watch) {
                Ok(live) => Graph::new(problem, &live, watch),
                Err(limit) => return Verdict::stopped(root.plan, watch.lower, limit),
            }
        }
    };
    let Some(graph) = graph else { return root };
    let verdict = exhaustive(&graph, most, options, root.plan.is_some(), watch);
    let Some(limit) = verdict.stopped_by else { return verdict };
    let plan = verdict.plan.into_iter().chain(root.plan).min_by_key(|plan| plan.0);
    Verdict::stopped(plan, watch.lower, limit)
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
