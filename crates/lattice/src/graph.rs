//! The poses that matter: reached from the start and with a way to a goal, by any moves however often.

use crate::by_node::ByNode;
use crate::problem::Arc;
use crate::watch::{self, Watch};
use crate::{Goal, Problem};

/// Number of a pose that does not matter.
const NONE: u32 = u32::MAX;

/// The live poses, renumbered as *nodes* in the order of their numbers, with arcs both ways.
pub(crate) struct Graph<'a> {
    pub problem: &'a Problem,
    /// Pose number by node.
    pub poses: Vec<u32>,
    pub start: u32,
    pub is_goal: Vec<bool>,
    pub goals: Vec<u32>,
    arcs: ByNode<Arc>,
    back: ByNode<Back>,
}

/// An arc seen from its end: the node where it starts, and its index.
#[derive(Clone, Copy, Default)]
pub(crate) struct Back {
    pub from: u32,
    pub arc: u32,
}

impl<'a> Graph<'a> {
    /// Nothing if no walk leads from the start to a goal, or if told to stop.
    pub fn new(problem: &'a Problem, reach: &Reach, watch: &mut Watch) -> Option<Self> {
        let start = problem.lattice().number(problem.start());
        if !reach.is_live(start) {
            return None;
        }
        let all = problem.lattice().poses();
        let poses: Vec<u32> = (0..all as u32).filter(|&pose| reach.is_live(pose as usize)).collect();
        let mut nodes = vec![NONE; all];
        for (node, &pose) in poses.iter().enumerate() {
            nodes[pose as usize] = node as u32;
        }
        let arcs = forward(problem, &poses, &nodes, watch)?;
        let back = backward(&arcs, poses.len());
        if !watch.go_on(poses.len() as u64) {
            return None;
        }
        let is_goal: Vec<bool> = poses.iter().map(|&pose| is_goal(problem, pose)).collect();
        let goals = (0..poses.len() as u32).filter(|&node| is_goal[node as usize]).collect();
        let start = nodes[start];
        Some(Self { problem, poses, start, is_goal, goals, arcs, back })
    }

    /// Number of nodes.
    pub fn len(&self) -> usize {
        self.poses.len()
    }

    /// Number of states: nodes times count vectors, as far as 128 bits go.
    pub fn states(&self) -> u128 {
        watch::strides(&self.problem.required()).1.saturating_mul(self.len() as u128)
    }

    /// Indices of the arcs from a node.
    pub fn range(&self, node: u32) -> std::ops::Range<u32> {
        self.arcs.range(node as usize)
    }

    /// The arc of an index.
    pub fn arc(&self, index: u32) -> Arc {
        self.arcs.entries()[index as usize]
    }

    /// The arcs from a node.
    pub fn arcs(&self, node: u32) -> &[Arc] {
        self.arcs.of(node as usize)
    }

    /// The arcs into a node.
    pub fn back(&self, node: u32) -> &[Back] {
        self.back.of(node as usize)
    }

    /// Key of a move and the slot of its action.
    pub fn price(&self, step: u32) -> (u64, Option<u32>) {
        let known = &self.problem.moves[step as usize];
        (known.key, known.slot)
    }

    /// Number of arcs.
    pub fn arc_count(&self) -> usize {
        self.arcs.entries().len()
    }

    /// Bytes that graph and problem hold, about.
    pub fn bytes(&self) -> u64 {
        (self.arc_count() * 24 + self.poses.len() * 28) as u64
    }
}

fn is_goal(problem: &Problem, pose: u32) -> bool {
    problem.is_goal(problem.lattice().pose(pose as usize))
}

/// Which poses are reached from the start, and from which a goal is reached, by any moves.
pub(crate) struct Reach {
    pub reached: Vec<bool>,
    pub homing: Vec<bool>,
}

impl Reach {
    /// Nothing if told to stop.
    pub fn new(problem: &Problem, watch: &mut Watch) -> Option<Self> {
        Some(Self { reached: reached(problem, watch)?, homing: homing(problem, watch)? })
    }

    fn is_live(&self, pose: usize) -> bool {
        self.reached[pose] && self.homing[pose]
    }
}

/// Which poses are reached from the start by any moves.
pub(crate) fn reached(problem: &Problem, watch: &mut Watch) -> Option<Vec<bool>> {
    let mut reached = vec![false; problem.lattice().poses()];
    let start = problem.lattice().number(problem.start());
    reached[start] = true;
    let mut stack = vec![start];
    while let Some(pose) = stack.pop() {
        if !watch.go_on(1) {
            return None;
        }
        for arc in problem.arcs(pose) {
            let end = arc.node as usize;
            if !std::mem::replace(&mut reached[end], true) {
                stack.push(end);
            }
        }
    }
    Some(reached)
}

/// From which poses any moves lead to a goal.
fn homing(problem: &Problem, watch: &mut Watch) -> Option<Vec<bool>> {
    let poses = problem.lattice().poses();
    let Goal::Poses(goals) = problem.goal() else {
        return Some(vec![true; poses]);
    };
    let starts = into_poses(problem);
    let mut homing = vec![false; poses];
    let mut stack: Vec<usize> = goals.iter().map(|&pose| problem.lattice().number(pose)).collect();
    stack.iter().for_each(|&pose| homing[pose] = true);
    while let Some(pose) = stack.pop() {
        if !watch.go_on(1) {
            return None;
        }
        for &start in starts.of(pose) {
            if !std::mem::replace(&mut homing[start as usize], true) {
                stack.push(start as usize);
            }
        }
    }
    Some(homing)
}

/// The poses with a move into each pose.
fn into_poses(problem: &Problem) -> ByNode<u32> {
    let poses = problem.lattice().poses();
    let starts = |pose: usize| problem.arcs(pose).iter().map(move |arc| (arc.node, pose as u32));
    ByNode::sorted(poses, || (0..poses).flat_map(starts))
}

/// Nothing if told to stop.
fn forward(problem: &Problem, poses: &[u32], nodes: &[u32], watch: &mut Watch) -> Option<ByNode<Arc>> {
    let mut arcs = ByNode::new();
    for &pose in poses {
        if !watch.go_on(1) {
            return None;
        }
        let inside = problem.arcs(pose as usize).iter().filter(|arc| nodes[arc.node as usize] != NONE);
        arcs.push(inside.map(|arc| Arc { node: nodes[arc.node as usize], step: arc.step }));
    }
    Some(arcs)
}

fn backward(arcs: &ByNode<Arc>, nodes: usize) -> ByNode<Back> {
    let back = |from: usize| {
        arcs.range(from).map(move |arc| (arcs.entries()[arc as usize].node, Back { from: from as u32, arc }))
    };
    ByNode::sorted(nodes, || (0..nodes).flat_map(back))
}
