use super::watch;
use crate::lattice::graph::{Graph, Reach, within};
use crate::lattice::layered::{self, Levels};
use crate::lattice::watch::{Verdict, Watch};
use crate::lattice::{
    Cost, Goal, Limit, NoPlan, Options, Pose, Problem, Progress, Reason, Solution, Status, beam, dense,
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
/// use plan::lattice::{Action, Cost, Goal, Lattice, Move, Options, Pose, Problem, plan};
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
/// # Ok::<(), plan::lattice::Invalid>(())
/// ```
pub fn plan(
    problem: &Problem,
    options: &Options,
    keep_going: &mut dyn FnMut(Progress) -> bool,
) -> Result<Solution, NoPlan> {
    let mut watch = Watch::new(problem, options.poll_every, keep_going);
    let out_of_time = NoPlan::OutOfTime { lower_bound: problem.cost(0, &problem.required()) };
    let Some(reach) = Reach::new(problem, &mut watch) else { return Err(out_of_time) };
    if let Some(reason) = from_map(problem, &reach) {
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
fn exhaustive_bytes(graph: &Graph) -> u128 {
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
        let step = problem.step(from, step);
        cost.primary += step.cost.primary;
        cost.secondary += step.cost.secondary;
        from = step.to;
        steps.push(step);
    }
    match stopped_by {
        None => Solution { status: Status::Optimal, cost, lower_bound: cost, steps },
        Some(stopped_by) => Solution { status: Status::Feasible { stopped_by }, cost, lower_bound, steps },
    }
}

/// A reason that the map alone gives, regardless of counts.
fn from_map(problem: &Problem, reach: &Reach) -> Option<Reason> {
    if problem.informative.is_empty() && problem.is_goal(problem.start()) {
        return None;
    }
    let lattice = problem.lattice();
    if problem.arcs(lattice.number(problem.start())).next().is_none() {
        let is_usable: Vec<bool> = (0..lattice.poses()).map(|at| problem.arcs(at).next().is_some()).collect();
        let start = problem.start();
        return Some(Reason::StartEnclosed { start, nearest: nearest(problem, &is_usable, &[start]) });
    }
    goal(problem, &reach.reached).or_else(|| use_of_each(problem, reach))
}

fn goal(problem: &Problem, reached: &[bool]) -> Option<Reason> {
    let Goal::Poses(goals) = problem.goal() else {
        return None;
    };
    let lattice = problem.lattice();
    if goals.iter().any(|&pose| reached[lattice.number(pose)]) {
        return None;
    }
    let mut entered = vec![false; lattice.poses()];
    for pose in 0..lattice.poses() {
        problem.arcs(pose).for_each(|arc| entered[arc.node as usize] = true);
    }
    if goals.iter().any(|&pose| entered[lattice.number(pose)]) {
        return Some(Reason::GoalUnreachable { nearest: nearest(problem, reached, goals) });
    }
    Some(Reason::GoalEnclosed { goal: goals[0], nearest: nearest(problem, &entered, &goals[..1]) })
}

fn use_of_each(problem: &Problem, Reach { reached, homing }: &Reach) -> Option<Reason> {
    let slots = problem.informative.len();
    let (mut there, mut within, mut on_the_way) = (vec![None; slots], vec![false; slots], vec![false; slots]);
    for (pose, &reached) in reached.iter().enumerate() {
        for arc in problem.arcs(pose) {
            let Some(slot) = problem.moves[arc.step as usize].slot.map(|slot| slot as usize) else {
                continue;
            };
            there[slot].get_or_insert(problem.lattice().pose(pose));
            within[slot] |= reached;
            on_the_way[slot] |= reached && homing[arc.node as usize];
        }
    }
    let slot = on_the_way.iter().position(|&fits| !fits)?;
    let action = problem.informative[slot].action;
    let name = problem.actions()[action].name.clone();
    if within[slot] {
        return Some(Reason::NoWayBack { action, name });
    }
    Some(Reason::FitsNowhere { action, name, elsewhere: there[slot] })
}

/// The pose among `candidates` nearest to any of `targets`; of several one in the target's layer, then the first.
fn nearest(problem: &Problem, candidates: &[bool], targets: &[Pose]) -> Option<(Pose, f64)> {
    let all = (0..candidates.len()).filter(|&pose| candidates[pose]).map(|pose| problem.lattice().pose(pose));
    let distance = |pose: Pose, target: &Pose| {
        let (di, dj) = (pose.i.abs_diff(target.i) as f64, pose.j.abs_diff(target.j) as f64);
        (libm::hypot(di, dj), pose.layer != target.layer)
    };
    let ranked = all.flat_map(|pose| targets.iter().map(move |target| (distance(pose, target), pose)));
    let least = ranked.min_by(|(a, _), (b, _)| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)))?;
    Some((least.1, least.0.0))
}

/// The least cost of a count vector.
#[derive(Clone, Debug, PartialEq)]
pub struct FrontPoint {
    /// Uses of every informative action, in the order of the problem's actions.
    pub counts: Vec<u32>,
    /// Least primary cost of a walk to a goal with exactly these uses; `None` if there is none.
    pub primary: Option<f64>,
}

/// Least primary cost of reaching the goal with exactly g uses, for every count vector g up to the required one, from
/// one exhaustive search: information against cost. One point per count vector, the first informative
/// action's count fastest; `None` if the search is cancelled or does not fit in the memory.
///
/// Where a `plan` of the problem is known, costs above its own may be missing: those counts are fewer and cost more than the plan. The
/// search then takes as long as the plan's surroundings are large, not the lattice.
pub fn front(
    problem: &Problem,
    plan: Option<&Solution>,
    options: &Options,
    keep_going: &mut dyn FnMut(Progress) -> bool,
) -> Option<Vec<FrontPoint>> {
    let required = problem.required();
    let vectors = watch::strides(&required).1;
    let own_bytes = vectors.saturating_mul((24 + size_of::<FrontPoint>() + 4 * required.len()) as u128);
    if own_bytes > u128::from(options.memory_bytes) {
        return None;
    }
    let mut watch = Watch::new(problem, options.poll_every, keep_going);
    let most = plan.map_or(u64::MAX, |plan| problem.whole_key(plan));
    let live = match plan {
        None => Reach::new(problem, &mut watch)?.live(),
        Some(_) => {
            let memory = u128::from(options.memory_bytes) - own_bytes;
            within(problem, most, memory as u64, &mut watch).ok()?
        }
    };
    let Some(graph) = Graph::new(problem, &live, &mut watch) else {
        return watch.keep_going(0).then(|| points(problem, &vec![None; vectors as usize]));
    };
    drop(live);
    let levels = Levels::of(&graph);
    let bytes = match levels {
        Some(_) => layered::front_bytes(&graph),
        // Distances are kept in 64 bits here.
        None => exhaustive_bytes(&graph).saturating_mul(2),
    };
    if bytes.saturating_add(own_bytes) + u128::from(graph.bytes()) > u128::from(options.memory_bytes) {
        return None;
    }
    let memory = options.memory_bytes.saturating_sub(graph.bytes());
    let keys = match levels {
        Some(levels) => layered::front(&graph, levels, most, &mut watch),
        None => dense::front(&graph, most, memory, &mut watch),
    };
    keys.map(|keys| points(problem, &keys))
}

fn points(problem: &Problem, keys: &[Option<u64>]) -> Vec<FrontPoint> {
    let required = problem.required();
    let point = |(number, key): (usize, &Option<u64>)| {
        let counts = watch::counts(number as u64, &required);
        let primary = key.map(|key| problem.cost(key, &counts).primary);
        FrontPoint { counts, primary }
    };
    keys.iter().enumerate().map(point).collect()
}
