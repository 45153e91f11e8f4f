//! Small random problems, written down plainly, and what plain means say about them.

use plan::lattice::{Action, Cost, Goal, Lattice, Move, MoveId, NoPlan, Pose, Problem, Solution};
use proptest::prelude::*;

/// Costs in tenths: (primary, secondary).
pub type Tenths = (u64, u64);

/// A problem before it is accepted. `closed[k]` closes the k-th (move, cell) pair, counted over all moves and cells.
#[derive(Clone, Debug)]
pub struct Small {
    pub lattice: Lattice,
    pub actions: Vec<Action>,
    pub start: Pose,
    pub goal: Goal,
    pub closed: Vec<bool>,
}

impl Small {
    pub fn allowed(&self, id: MoveId, i: usize, j: usize) -> bool {
        let before: usize = self.actions[..id.action].iter().map(|action| action.moves.len()).sum();
        let cell = j * self.lattice.nx + i;
        let pair = (before + id.index) * self.lattice.nx * self.lattice.ny + cell;
        !self.closed[pair % self.closed.len()]
    }

    pub fn problem(&self) -> Problem {
        let allowed = |id, i, j| self.allowed(id, i, j);
        Problem::new(self.lattice, self.actions.clone(), self.start, self.goal.clone(), allowed).unwrap()
    }

    pub fn is_goal(&self, pose: Pose) -> bool {
        match &self.goal {
            Goal::Any => true,
            Goal::Poses(poses) => poses.contains(&pose),
        }
    }

    /// Where a move leads, if it is allowed.
    pub fn after(&self, pose: Pose, action: usize, index: usize) -> Option<Pose> {
        let m = self.actions[action].moves[index];
        let (i, j) = (pose.i as i64 + i64::from(m.di), pose.j as i64 + i64::from(m.dj));
        let inside = i >= 0 && j >= 0 && i < self.lattice.nx as i64 && j < self.lattice.ny as i64;
        let may = m.from == pose.layer && inside && self.allowed(MoveId { action, index }, pose.i, pose.j);
        may.then_some(Pose { i: i as usize, j: j as usize, layer: m.to })
    }
}

/// Which costs moves have.
#[derive(Clone, Copy, Debug)]
pub enum Costs {
    /// 0 for informative actions, 1 for basic ones.
    Paper,
    /// Like `Paper`, some basic actions free.
    SomeFree,
    /// Like `SomeFree`, and seconds per move as the secondary cost.
    MovesThenSeconds,
    /// Tenths of seconds, one value per action.
    Seconds,
    /// Anything per move, and a secondary cost.
    Both,
}

pub fn small(costs: Costs) -> impl Strategy<Value = Small> {
    let sizes = (1..=5usize, 1..=4usize, 1..=3usize);
    (sizes, 0..=3usize, 1..=3usize).prop_flat_map(move |((nx, ny, layers), informative, basic)| {
        let lattice = Lattice { nx, ny, layers };
        let pose = move || (0..nx, 0..ny, 0..layers).prop_map(|(i, j, layer)| Pose { i, j, layer });
        let goal = prop_oneof![
            1 => Just(Goal::Any),
            4 => prop::collection::vec(pose(), 1..=3).prop_map(Goal::Poses),
        ];
        let required = prop::collection::vec(1..=3u32, informative);
        let informative = prop::collection::vec(prop::collection::vec(shape(layers), 2..=7), informative);
        let basic = prop::collection::vec(prop::collection::vec(shape(layers), 3..=8), basic);
        let closed = prop::collection::vec(prop::bool::weighted(0.1), 97);
        (required, informative, basic, pose(), goal, closed).prop_map(
            move |(required, informative, basic, start, goal, closed)| {
                let all = required
                    .iter()
                    .copied()
                    .zip(informative)
                    .chain(basic.into_iter().map(|moves| (0, moves)));
                let build = |(index, (required, shapes)): (usize, (u32, Vec<Shape>))| {
                    let moves =
                        shapes.iter().map(|shape| shape.cost(costs, required > 0, shapes[0].draw)).collect();
                    Action { name: format!("a{index}"), required, moves }
                };
                let actions = all.enumerate().map(build).collect();
                Small { lattice, actions, start, goal, closed }
            },
        )
    })
}

/// A move and two drawn numbers for its cost.
#[derive(Clone, Debug)]
pub struct Shape {
    shape: Move,
    draw: (u64, u64),
}

impl Shape {
    fn cost(&self, costs: Costs, informative: bool, of_action: (u64, u64)) -> Move {
        let tenths = match costs {
            Costs::Paper => (if informative { 0 } else { 10 }, 0),
            Costs::SomeFree => (if informative || of_action.0 < 15 { 0 } else { 10 }, 0),
            Costs::MovesThenSeconds => {
                (if informative || of_action.0 < 15 { 0 } else { 10 }, 10 * (self.draw.0 % 7) + self.draw.1)
            }
            Costs::Seconds => (of_action.0 * 7, 0),
            Costs::Both => (self.draw.0 / 10, self.draw.1),
        };
        let cost = Cost { primary: tenths.0 as f64 / 10.0, secondary: tenths.1 as f64 / 10.0 };
        Move { cost, ..self.shape }
    }
}

fn shape(layers: usize) -> impl Strategy<Value = Shape> {
    (0..layers, -2..=2i32, -2..=2i32, 0..layers, (0..60u64, 0..9u64)).prop_map(|(from, di, dj, to, draw)| {
        Shape { shape: Move { from, di, dj, to, cost: Cost::default() }, draw }
    })
}

fn tenths(cost: Cost) -> Tenths {
    ((cost.primary * 10.0).round() as u64, (cost.secondary * 10.0).round() as u64)
}

/// Least cost of every count vector at any goal, first informative action fastest: Bellman and Ford's method over all
/// states, until nothing changes.
pub fn brute_force(small: &Small) -> Vec<Option<Tenths>> {
    let slots: Vec<usize> = (0..small.actions.len()).filter(|&a| small.actions[a].required > 0).collect();
    let radix: Vec<usize> = slots.iter().map(|&a| small.actions[a].required as usize + 1).collect();
    let vectors: usize = radix.iter().product();
    let Lattice { nx, ny, layers } = small.lattice;
    let poses: Vec<Pose> =
        (0..nx * ny * layers).map(|p| Pose { i: p % nx, j: p / nx % ny, layer: p / nx / ny }).collect();
    let number = |pose: Pose| (pose.layer * ny + pose.j) * nx + pose.i;
    let mut least: Vec<Vec<Option<Tenths>>> = vec![vec![None; poses.len()]; vectors];
    least[0][number(small.start)] = Some((0, 0));
    let mut changed = true;
    while changed {
        changed = false;
        for vector in 0..vectors {
            for &pose in &poses {
                let Some(here) = least[vector][number(pose)] else { continue };
                for (action, a) in small.actions.iter().enumerate() {
                    let mut to = vector;
                    if let Some(slot) = slots.iter().position(|&other| other == action) {
                        let stride: usize = radix[..slot].iter().product();
                        if vector / stride % radix[slot] + 1 == radix[slot] {
                            continue;
                        }
                        to += stride;
                    }
                    for (index, m) in a.moves.iter().enumerate() {
                        let Some(end) = small.after(pose, action, index) else { continue };
                        let cost = tenths(m.cost);
                        let cost = (here.0 + cost.0, here.1 + cost.1);
                        let known = &mut least[to][number(end)];
                        if known.is_none_or(|known| cost < known) {
                            *known = Some(cost);
                            changed = true;
                        }
                    }
                }
            }
        }
    }
    let at_goal = |vector: &Vec<Option<Tenths>>| {
        poses.iter().filter(|&&pose| small.is_goal(pose)).filter_map(|&pose| vector[number(pose)]).min()
    };
    least.iter().map(at_goal).collect()
}

/// Checks a plan step by step and returns its cost.
pub fn replay(small: &Small, solution: &Solution) -> Tenths {
    let mut pose = small.start;
    let mut uses = vec![0; small.actions.len()];
    let mut cost = (0, 0);
    for step in &solution.steps {
        let action = &small.actions[step.action];
        let variants = (0..action.moves.len()).filter(|&index| action.moves[index].from == pose.layer);
        let index = variants.clone().nth(step.variant).expect("a variant of this layer");
        assert_eq!(step.from, pose);
        assert_eq!(step.cost, action.moves[index].cost);
        pose = small.after(pose, step.action, index).expect("an allowed move");
        assert_eq!(step.to, pose);
        uses[step.action] += 1;
        cost = (cost.0 + tenths(step.cost).0, cost.1 + tenths(step.cost).1);
    }
    assert!(small.is_goal(pose), "the plan ends in a goal");
    for (action, &uses) in small.actions.iter().zip(&uses) {
        assert!(action.required == 0 || action.required == uses, "{} is used {uses} times", action.name);
    }
    assert_eq!(tenths(solution.cost), cost);
    cost
}

/// Cost of an outcome after its plan was replayed; nothing if proved infeasible. Anything else fails.
#[allow(dead_code)]
pub fn proved(small: &Small, outcome: &Result<Solution, NoPlan>) -> Option<Tenths> {
    match outcome {
        Err(NoPlan::Infeasible(_)) => None,
        Ok(solution) => {
            assert_eq!(solution.status, plan::lattice::Status::Optimal);
            assert_eq!(solution.lower_bound, solution.cost);
            Some(replay(small, solution))
        }
        other => panic!("neither solved nor infeasible: {other:?}"),
    }
}
