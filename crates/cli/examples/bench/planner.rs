//! The planner on made-up archipelagos, and `pathfinding`'s searches on the smallest of them.

use std::time::Instant;

use anyhow::{Context, ensure};
use pathfinding::prelude::{astar, dijkstra};
use plan::lattice::{MoveId, Options, Pose, Problem, Status, plan};
use serde_json::{Value, json};

use crate::timing::fastest;

#[path = "../../../plan/tests/all/lattice/synthetic.rs"]
mod synthetic;

/// Uses so far, eight bits for each informative action.
type Uses = u64;
/// A pose's number and the uses so far.
type State = (u32, Uses);

/// Cells, headings, informative actions and uses of each. The first is the paper's size.
const SIZES: [(&str, [usize; 5], usize); 4] = [
    ("35x44x4_3x3", [35, 44, 4, 3, 3], 20),
    ("140x176x16_3x3", [140, 176, 16, 3, 3], 2),
    ("35x44x4_11x1", [35, 44, 4, 11, 1], 3),
    ("35x44x4_11x2", [35, 44, 4, 11, 2], 1),
];
const SEED: u64 = 1;
const MEMORY_BYTES: u64 = 8 << 30;

/// Seconds for allowed moves and plan of every size, and the peers' for the plan of the first.
pub fn measure() -> anyhow::Result<Value> {
    let mut object = serde_json::Map::new();
    for (name, size, repetitions) in SIZES {
        object.insert(name.into(), ours(size, repetitions)?);
    }
    object.insert("pathfinding".into(), peers(SIZES[0].1, 3)?);
    Ok(object.into())
}

fn problem([nx, ny, headings, informative, count]: [usize; 5]) -> anyhow::Result<(f64, Problem)> {
    let file = synthetic::archipelago(nx, ny, headings, informative, count as u32, SEED);
    fastest(3, || Ok(file.into_problem()?))
}

fn solve(problem: &Problem) -> anyhow::Result<f64> {
    let options = Options { memory_bytes: MEMORY_BYTES, ..Options::default() };
    match plan(problem, &options, &mut |_| true) {
        Ok(solution) if solution.status == Status::Optimal => Ok(solution.cost.primary),
        other => anyhow::bail!("no proved plan: {other:?}"),
    }
}

fn ours(size: [usize; 5], repetitions: usize) -> anyhow::Result<Value> {
    let (table_s, problem) = problem(size)?;
    let (plan_s, cost) = fastest(repetitions, || solve(&problem))?;
    Ok(json!({ "table_s": table_s, "plan_s": plan_s, "cost": cost }))
}

/// An allowed move from a pose: its end, what it adds to the uses, its cost.
struct Way {
    end: u32,
    adds: Uses,
    cost: u32,
}

/// Everything a generic search needs, prepared before the clock starts.
struct Peer {
    ways: Vec<Vec<Way>>,
    start: State,
    goal: State,
    /// Least cost to the goal by pose, whatever the counts: an admissible and consistent heuristic.
    to_go: Vec<u32>,
    /// The count of every informative action.
    count: u64,
}

fn peers(size: [usize; 5], repetitions: usize) -> anyhow::Result<Value> {
    let (_, problem) = problem(size)?;
    let optimum = solve(&problem)?;
    let peer = Peer::new(&problem, size[3], size[4] as u64)?;
    let from = |state: &State| peer.successors(*state);
    let is_goal = |state: &State| *state == peer.goal;
    let (dijkstra_s, found) =
        fastest(repetitions, || dijkstra(&peer.start, from, is_goal).context("dijkstra found no plan"))?;
    ensure!(f64::from(found.1) == optimum, "dijkstra found {}, the planner {optimum}", found.1);
    let to_go = |state: &State| peer.to_go[state.0 as usize];
    let started = Instant::now();
    let found = astar(&peer.start, from, to_go, is_goal).context("astar found no plan")?;
    let mut astar_s = started.elapsed().as_secs_f64();
    ensure!(f64::from(found.1) == optimum, "astar found {}, the planner {optimum}", found.1);
    let again = fastest(repetitions, || Ok(astar(&peer.start, from, to_go, is_goal)))?;
    astar_s = astar_s.min(again.0);
    Ok(json!({ "dijkstra_s": dijkstra_s, "astar_s": astar_s }))
}

impl Peer {
    fn new(problem: &Problem, informative: usize, count: u64) -> anyhow::Result<Self> {
        let lattice = problem.lattice();
        let number = |pose: Pose| ((pose.layer * lattice.ny + pose.j) * lattice.nx + pose.i) as u32;
        let mut ways: Vec<Vec<Way>> = (0..lattice.nx * lattice.ny * lattice.layers).map(|_| vec![]).collect();
        for (action, a) in problem.actions().iter().enumerate() {
            let adds = if a.required > 0 { 1 << (8 * action) } else { 0 };
            for (index, step) in a.moves.iter().enumerate() {
                for cell in 0..lattice.nx * lattice.ny {
                    let pose = Pose { i: cell % lattice.nx, j: cell / lattice.nx, layer: step.from };
                    if problem.is_allowed(pose, MoveId { action, index }) {
                        let i = (pose.i as i64 + i64::from(step.di)) as usize;
                        let j = (pose.j as i64 + i64::from(step.dj)) as usize;
                        let end = number(Pose { i, j, layer: step.to });
                        ways[number(pose) as usize].push(Way { end, adds, cost: step.cost.primary as u32 });
                    }
                }
            }
        }
        let plan::lattice::Goal::Poses(goals) = problem.goal() else { anyhow::bail!("a goal is wanted") };
        let goal = (number(goals[0]), (0..informative).map(|slot| count << (8 * slot)).sum());
        let to_go = to_go(&ways, goal.0);
        Ok(Self { ways, start: (number(problem.start()), 0), goal, to_go, count })
    }

    fn successors(&self, (pose, uses): State) -> impl Iterator<Item = (State, u32)> + '_ {
        self.ways[pose as usize].iter().filter_map(move |way| {
            let shift = way.adds.trailing_zeros();
            let may = way.adds == 0 || (uses >> shift & 0xff) < self.count;
            may.then_some(((way.end, uses + way.adds), way.cost))
        })
    }
}

/// Least cost from every pose to the goal by relaxing until nothing changes.
fn to_go(ways: &[Vec<Way>], goal: u32) -> Vec<u32> {
    let unreached = u32::MAX / 2;
    let mut to_go = vec![unreached; ways.len()];
    to_go[goal as usize] = 0;
    loop {
        let mut changed = false;
        for (pose, ways) in ways.iter().enumerate() {
            let least = ways.iter().map(|way| way.cost + to_go[way.end as usize]).min().unwrap_or(unreached);
            if least < to_go[pose] {
                to_go[pose] = least;
                changed = true;
            }
        }
        if !changed {
            return to_go;
        }
    }
}
