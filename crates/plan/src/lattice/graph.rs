//! The live poses: those that can be reached from the start and can reach a goal, by any number of moves.

use std::cell::OnceCell;

use super::grid::Arc;
use super::watch::RadixHeap;
use crate::lattice::watch::{self, Watch, filled};
use crate::lattice::{Action, Goal, Lattice, Limit, MoveId, Pose, Problem, Step};

/// The number of a pose that is not live.
const NONE: u32 = u32::MAX;

/// Bytes of a pose in the tables of [`within`]: its least keys from the start and to a goal, and whether plans pass.
pub(crate) const WITHIN_PER_POSE: usize = 2 * size_of::<u64>() + size_of::<bool>();
/// Poses between two checks of the queue's memory.
const LOOKS: u32 = 1 << 10;

/// The live poses, renumbered as *nodes* in the order of their numbers, with the arcs between them.
pub(crate) struct Graph<'a> {
    pub problem: &'a Problem,
    /// Pose number by node.
    pub poses: Vec<u32>,
    pub start: u32,
    pub is_goal: Vec<bool>,
    pub goals: Vec<u32>,
    /// Node by pose number.
    nodes: Vec<u32>,
    /// All arcs, and the same by their ends, for engines that traverse them repeatedly.
    arcs: OnceCell<ByNode<Arc>>,
    back: OnceCell<ByNode<Back>>,
}

/// An arc seen from its end: the node where it starts, and its index.
#[derive(Clone, Copy, Default)]
pub(crate) struct Back {
    pub from: u32,
    pub arc: u32,
}

impl<'a> Graph<'a> {
    /// Of the poses that are `live`. `None` if the start is not, or if cancelled.
    pub fn new(problem: &'a Problem, live: &[bool], watch: &mut Watch) -> Option<Self> {
        let start = problem.lattice().number(problem.start());
        if !live[start] {
            return None;
        }
        let all = problem.lattice().poses();
        let poses: Vec<u32> = (0..all as u32).filter(|&pose| live[pose as usize]).collect();
        let mut nodes = vec![NONE; all];
        for (node, &pose) in poses.iter().enumerate() {
            nodes[pose as usize] = node as u32;
        }
        if !watch.keep_going(all as u64) {
            return None;
        }
        let is_goal: Vec<bool> = poses.iter().map(|&pose| is_goal(problem, pose)).collect();
        let goals = (0..poses.len() as u32).filter(|&node| is_goal[node as usize]).collect();
        let (start, arcs, back) = (nodes[start], OnceCell::new(), OnceCell::new());
        Some(Self { problem, poses, start, is_goal, goals, nodes, arcs, back })
    }

    /// Stores the arcs; both ways for [`Self::back`]. `None` if cancelled.
    pub fn lay_out(&self, both_ways: bool, watch: &mut Watch) -> Option<()> {
        if self.arcs.get().is_none() {
            let mut arcs = ByNode::with_capacity(self.len(), self.arc_count());
            for node in 0..self.len() as u32 {
                arcs.push(self.ways(node));
                watch.keep_going(1).then_some(())?;
            }
            self.arcs.get_or_init(|| arcs);
        }
        if both_ways && self.back.get().is_none() {
            let back = backward(self.laid_out(), self.len(), watch)?;
            self.back.get_or_init(|| back);
        }
        watch.keep_going(self.len() as u64).then_some(())
    }

    fn laid_out(&self) -> &ByNode<Arc> {
        self.arcs.get().unwrap_or_else(|| unreachable!("engines lay out the arcs first"))
    }

    /// The arcs from a node, computed on demand.
    pub fn ways(&self, node: u32) -> impl Iterator<Item = Arc> + '_ {
        let arcs = self.problem.arcs(self.poses[node as usize] as usize);
        arcs.map(|arc| Arc { node: self.nodes[arc.node as usize], ..arc }).filter(|arc| arc.node != NONE)
    }

    /// The starts of the arcs into a node, and their moves, computed on demand.
    pub fn ways_into(&self, node: u32) -> impl Iterator<Item = (u32, u32)> + '_ {
        let arcs = self.problem.arcs_into(self.poses[node as usize] as usize);
        arcs.map(|arc| (self.nodes[arc.node as usize], arc.step)).filter(|(from, _)| *from != NONE)
    }

    /// Number of nodes.
    pub fn len(&self) -> usize {
        self.poses.len()
    }

    /// Number of states: nodes times count vectors, saturating at 128 bits.
    pub fn states(&self) -> u128 {
        watch::strides(&self.problem.required()).1.saturating_mul(self.len() as u128)
    }

    /// The arc of an index.
    pub fn arc(&self, index: u32) -> Arc {
        self.laid_out().entries()[index as usize]
    }

    /// The arcs from a node.
    pub fn arcs(&self, node: u32) -> &[Arc] {
        self.laid_out().of(node as usize)
    }

    /// The arcs into a node.
    pub fn back(&self, node: u32) -> &[Back] {
        let back = self.back.get().unwrap_or_else(|| unreachable!("engines lay out the arcs first"));
        back.of(node as usize)
    }

    /// Key of a move and the slot of its action.
    pub fn price(&self, step: u32) -> (u64, Option<u32>) {
        let known = &self.problem.moves[step as usize];
        (known.key, known.slot)
    }

    /// Number of arcs, at most.
    pub fn arc_count(&self) -> usize {
        self.problem.arc_count(|_| true)
    }

    /// Approximate bytes of graph and problem, before arcs are stored.
    pub fn bytes(&self) -> u64 {
        (self.nodes.len() * 8 + self.poses.len() * 8) as u64
    }

    /// Approximate bytes of stored arcs.
    pub fn arc_bytes(&self, both_ways: bool) -> u64 {
        let one_way = (self.arc_count() * 8 + self.len() * 4) as u64;
        if both_ways { 2 * one_way } else { one_way }
    }
}

fn is_goal(problem: &Problem, pose: u32) -> bool {
    problem.is_goal(problem.lattice().pose(pose as usize))
}

/// The poses that are reached from the start, and those from which a goal is reached, by any moves.
pub(crate) struct Reach {
    pub reached: Vec<bool>,
    pub homing: Vec<bool>,
}

impl Reach {
    /// `None` if cancelled.
    pub fn new(problem: &Problem, watch: &mut Watch) -> Option<Self> {
        Some(Self { reached: reached(problem, watch)?, homing: homing(problem, watch)? })
    }

    /// Whether walks from the start to a goal pass, by pose.
    pub fn live(self) -> Vec<bool> {
        self.reached.into_iter().zip(self.homing).map(|(reached, homing)| reached && homing).collect()
    }
}

/// The poses that plans with keys of at most `most` can pass, and maybe some more: those near start and goals, however large the
/// lattice is. Plans use informative actions no more often than required. So with a price on each use, their priced keys are at most
/// `most` and all prices, and no priced walk through a pose is below its least one.
pub(crate) fn within(problem: &Problem, most: u64, room: u64, watch: &mut Watch) -> Result<Vec<bool>, Limit> {
    let tables = (problem.lattice().poses() * WITHIN_PER_POSE) as u64;
    let queued = room.checked_sub(tables).ok_or(Limit::Memory)?;
    let number = |pose| problem.lattice().number(pose) as u32;
    let uses = problem.required().iter().map(|&count| u64::from(count)).sum::<u64>();
    let price = most / uses.max(1);
    let most = most + price * uses;
    let key = |step: u32| {
        let known = &problem.moves[step as usize];
        Some(known.key + if known.slot.is_some() { price } else { 0 })
    };
    let start = vec![(0, number(problem.start()))];
    let begun = least_keys(problem, start, (&key, most), queued, |pose| problem.arcs(pose), watch)?;
    let Goal::Poses(goals) = problem.goal() else {
        return Ok(begun.into_iter().map(|key| key <= most).collect());
    };
    let goals = goals.iter().map(|&pose| (0, number(pose))).collect();
    let left = least_keys(problem, goals, (&key, most), queued, |pose| problem.arcs_into(pose), watch)?;
    Ok(begun.into_iter().zip(left).map(|(begun, left)| begun.saturating_add(left) <= most).collect())
}

/// By pose the least sum of a walk along `arcs` from any of `ends`, which have keys themselves, and of the moves that `key` has one
/// of; `u64::MAX` where it is above `most`.
fn least_keys<I: Iterator<Item = Arc>>(
    problem: &Problem,
    ends: Vec<(u64, u32)>,
    (key, most): (&dyn Fn(u32) -> Option<u64>, u64),
    memory: u64,
    arcs: impl Fn(usize) -> I,
    watch: &mut Watch,
) -> Result<Vec<u64>, Limit> {
    let mut least = filled(problem.lattice().poses(), u64::MAX, watch).ok_or(Limit::Time)?;
    let mut queue = RadixHeap::<u64, u32>::new();
    for (key, pose) in ends {
        let known = &mut least[pose as usize];
        *known = key.min(*known);
        queue.push(key, pose);
    }
    let mut popped = 0_u32;
    while let Some((so_far, pose)) = queue.pop() {
        watch.keep_going(1).then_some(()).ok_or(Limit::Time)?;
        popped = popped.wrapping_add(1);
        if popped.is_multiple_of(LOOKS) && queue.bytes() > memory {
            return Err(Limit::Memory);
        }
        if least[pose as usize] < so_far {
            continue;
        }
        for arc in arcs(pose as usize) {
            let (Some(key), known) = (key(arc.step), &mut least[arc.node as usize]) else { continue };
            let there = so_far + key;
            if there <= most && there < *known {
                *known = there;
                queue.push(there, arc.node);
            }
        }
    }
    Ok(least)
}

/// The key of a pose where walks may end, or of a move, which is above 0; `None` of any other.
pub(crate) type KeyOf<'a, T> = Box<dyn Fn(T) -> Option<u64> + 'a>;

/// The cheapest walks from all poses to any of several ends.
pub(crate) struct WaysOut<'a> {
    problem: &'a Problem,
    end: KeyOf<'a, Pose>,
    key: KeyOf<'a, MoveId>,
    /// By pose: the least sum of such keys.
    least: Vec<u64>,
}

impl<'a> WaysOut<'a> {
    /// Searched backward from the ends.
    pub fn new(
        problem: &'a Problem,
        (end, key): (KeyOf<'a, Pose>, KeyOf<'a, MoveId>),
        memory: u64,
        watch: &mut Watch,
    ) -> Result<Self, Limit> {
        let (lattice, bytes) = (problem.lattice(), size_of::<u64>() * problem.lattice().poses());
        let queued = memory.checked_sub(bytes as u64).ok_or(Limit::Memory)?;
        let ends = (0..lattice.poses()).filter_map(|pose| Some((end(lattice.pose(pose))?, pose as u32)));
        let of_step = |step: u32| key(problem.moves[step as usize].id);
        let into = |pose| problem.arcs_into(pose);
        let least = least_keys(problem, ends.collect(), (&of_step, u64::MAX / 2), queued, into, watch)?;
        Ok(Self { problem, end, key, least })
    }

    /// By pose: whether no walk leads to an end.
    pub fn closed(self) -> Vec<bool> {
        self.least.into_iter().map(|key| key == u64::MAX).collect()
    }

    /// The moves from `pose` to its end; none where it is one, `None` where no end is reached.
    pub fn steps(&self, mut pose: Pose) -> Option<Vec<Step>> {
        let (lattice, mut steps) = (self.problem.lattice(), Vec::new());
        loop {
            let number = lattice.number(pose);
            let left = Some(self.least[number]).filter(|key| *key < u64::MAX)?;
            if (self.end)(pose) == Some(left) {
                return Some(steps);
            }
            let leads = |arc: &Arc| {
                let key = (self.key)(self.problem.moves[arc.step as usize].id);
                key.is_some_and(|key| self.least[arc.node as usize].checked_add(key) == Some(left))
            };
            let step = self.problem.step(pose, self.problem.arcs(number).find(leads)?.step);
            pose = step.to;
            steps.push(step);
        }
    }
}

/// The poses that are reached from the start by any moves.
pub(crate) fn reached(problem: &Problem, watch: &mut Watch) -> Option<Vec<bool>> {
    let start = problem.lattice().number(problem.start()) as u32;
    flooded(problem, vec![start], |pose| problem.arcs(pose), watch)
}

/// The poses from which any moves lead to a goal.
fn homing(problem: &Problem, watch: &mut Watch) -> Option<Vec<bool>> {
    let Goal::Poses(goals) = problem.goal() else { return Some(vec![true; problem.lattice().poses()]) };
    let goals = goals.iter().map(|&pose| problem.lattice().number(pose) as u32).collect();
    flooded(problem, goals, |pose| problem.arcs_into(pose), watch)
}

/// The poses that `arcs` lead to from any of `ends`, and these. `None` if cancelled.
fn flooded<I: Iterator<Item = Arc>>(
    problem: &Problem,
    ends: Vec<u32>,
    arcs: impl Fn(usize) -> I,
    watch: &mut Watch,
) -> Option<Vec<bool>> {
    let mut flooded = vec![false; problem.lattice().poses()];
    ends.iter().for_each(|&pose| flooded[pose as usize] = true);
    let mut stack = ends;
    while let Some(pose) = stack.pop() {
        watch.keep_going(1).then_some(())?;
        for arc in arcs(pose as usize) {
            if !std::mem::replace(&mut flooded[arc.node as usize], true) {
                stack.push(arc.node);
            }
        }
    }
    Some(flooded)
}

/// `None` if cancelled.
fn backward(arcs: &ByNode<Arc>, nodes: usize, watch: &mut Watch) -> Option<ByNode<Back>> {
    let back = |from: usize| {
        arcs.range(from).map(move |arc| (arcs.entries()[arc as usize].node, Back { from: from as u32, arc }))
    };
    ByNode::sorted(nodes, || (0..nodes).flat_map(back), watch)
}

/// Some entries of every node.
#[derive(Clone, Debug)]
pub(crate) struct ByNode<T> {
    /// Where the entries of each node begin; then where the last end.
    offsets: Vec<u32>,
    entries: Vec<T>,
}

impl<T> ByNode<T> {
    /// Without nodes yet, with capacity for `nodes` and `entries`.
    pub fn with_capacity(nodes: usize, entries: usize) -> Self {
        let mut offsets = Vec::with_capacity(nodes + 1);
        offsets.push(0);
        Self { offsets, entries: Vec::with_capacity(entries) }
    }

    /// Adds the next node with its entries.
    pub fn push(&mut self, entries: impl IntoIterator<Item = T>) {
        self.entries.extend(entries);
        self.offsets.push(self.entries.len() as u32);
    }

    /// The entries of a node.
    pub fn of(&self, node: usize) -> &[T] {
        let range = self.range(node);
        &self.entries[range.start as usize..range.end as usize]
    }

    /// Indices of a node's entries.
    pub fn range(&self, node: usize) -> std::ops::Range<u32> {
        self.offsets[node]..self.offsets[node + 1]
    }

    /// The entries of all nodes.
    pub fn entries(&self) -> &[T] {
        &self.entries
    }
}

impl<T: Copy + Default> ByNode<T> {
    /// For `nodes` nodes, from entries in any order, each with its node; the order within a node is kept. `None` if cancelled.
    pub fn sorted<I: Iterator<Item = (u32, T)>>(
        nodes: usize,
        entries: impl Fn() -> I,
        watch: &mut Watch,
    ) -> Option<Self> {
        let mut offsets = vec![0; nodes + 1];
        for (node, _) in entries() {
            offsets[node as usize + 1] += 1;
            watch.keep_going(1).then_some(())?;
        }
        for node in 0..nodes {
            offsets[node + 1] += offsets[node];
        }
        let mut next = offsets.clone();
        let mut sorted = vec![T::default(); offsets[nodes] as usize];
        for (node, entry) in entries() {
            let at = &mut next[node as usize];
            sorted[*at as usize] = entry;
            *at += 1;
            watch.keep_going(1).then_some(())?;
        }
        Some(Self { offsets, entries: sorted })
    }
}

/// Approximate bytes of a pose in the tables of graph and search together.
const PER_POSE: u128 = 28;
/// Bytes of a pose while the surroundings of start and goals are searched: those of the graph, and of [`WITHIN_PER_POSE`].
const PER_POSE_WITHIN: u128 = 16 + WITHIN_PER_POSE as u128;
/// Approximate bytes of an allowed move: a bit in the problem, and one entry in the tables of a search.
const PER_MOVE: u128 = 10;

/// The demand of a lattice with its moves, known before anything is allocated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Demand {
    /// Poses.
    pub poses: u128,
    /// Moves that stay in the lattice, over all poses: the number of allowed ones without obstacles.
    pub moves: u128,
}

impl Demand {
    /// For a lattice with these actions.
    pub fn new(lattice: Lattice, actions: &[Action]) -> Self {
        let Lattice { nx, ny, layers } = lattice;
        let left = |count: usize, step: i32| count.saturating_sub(step.unsigned_abs() as usize) as u128;
        let moves = actions.iter().flat_map(|action| &action.moves);
        let moves = moves.map(|step| left(nx, step.di).saturating_mul(left(ny, step.dj)));
        let poses = [ny, layers].into_iter().fold(nx as u128, |all, n| all.saturating_mul(n as u128));
        Self { poses, moves: moves.fold(0, u128::saturating_add) }
    }

    /// Approximate bytes of problem, graph and arcs of a search at most; its states need more.
    pub fn bytes(&self) -> u128 {
        let search = self.poses.saturating_mul(PER_POSE).saturating_add(self.moves.saturating_mul(PER_MOVE));
        search.max(self.poses.saturating_mul(PER_POSE_WITHIN).saturating_add(self.moves / 8))
    }

    /// Approximate bytes of the problem that remain after the search: a bit for each move.
    pub fn kept_bytes(&self) -> u128 {
        self.moves / 8
    }
}
