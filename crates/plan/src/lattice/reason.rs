//! Why there is no plan, in terms of the map.

use std::fmt;

use crate::lattice::graph::Reach;
use crate::lattice::{Goal, Pose, Problem};

/// Why no plan exists. Every reason is proved.
#[derive(Clone, Debug, PartialEq)]
pub enum Reason {
    /// No move is allowed from the start.
    StartEnclosed {
        /// The start.
        start: Pose,
        /// The pose nearest to it from which a move is allowed, if there is one, and its distance in cells.
        nearest: Option<(Pose, f64)>,
    },
    /// No move is allowed into any goal.
    GoalEnclosed {
        /// The first goal of the problem.
        goal: Pose,
        /// The pose nearest to it into which a move is allowed, if there is one, and its distance in cells.
        nearest: Option<(Pose, f64)>,
    },
    /// No walk leads from the start to a goal, regardless of counts.
    GoalUnreachable {
        /// The reached pose nearest to a goal, and its distance in cells.
        nearest: Option<(Pose, f64)>,
    },
    /// An informative action is allowed nowhere that can be reached.
    FitsNowhere {
        /// Index of the action.
        action: usize,
        /// Its name.
        name: String,
        /// A pose from which it is allowed, but which cannot be reached.
        elsewhere: Option<Pose>,
    },
    /// An informative action can be used, but afterwards no walk leads to a goal.
    NoWayBack {
        /// Index of the action.
        action: usize,
        /// Its name.
        name: String,
    },
    /// Each informative action can be used, but no walk uses all of them as often as required and ends in a goal.
    CountsCannotBeCombined {
        /// Counts that can be had, as many uses in total as any, by informative action; known after an exhaustive
        /// search.
        possible: Option<Vec<u32>>,
    },
}

impl fmt::Display for Reason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::StartEnclosed { start, nearest } => {
                write!(f, "no move is allowed from the start {start}")?;
                near(f, "the nearest pose with room is", nearest)
            }
            Self::GoalEnclosed { goal, nearest } => {
                write!(f, "no move is allowed into the goal {goal}")?;
                near(f, "the nearest pose with room is", nearest)
            }
            Self::GoalUnreachable { nearest } => {
                write!(f, "no moves lead from the start to the goal")?;
                near(f, "the nearest pose that is reached is", nearest)
            }
            Self::FitsNowhere { name, elsewhere: None, .. } => {
                write!(f, "{name} fits nowhere on the lattice")
            }
            Self::FitsNowhere { name, elsewhere: Some(pose), .. } => {
                write!(f, "{name} fits nowhere that can be reached, though it would at {pose}")
            }
            Self::NoWayBack { name, .. } => {
                write!(f, "after {name} there is no way to the goal, wherever it is used")
            }
            Self::CountsCannotBeCombined { possible } => {
                write!(
                    f,
                    "each maneuver can be used, but the required counts cannot be combined on any way to the goal"
                )?;
                match possible {
                    Some(counts) => write!(f, "; the counts {counts:?} can"),
                    None => Ok(()),
                }
            }
        }
    }
}

fn near(f: &mut fmt::Formatter<'_>, what: &str, nearest: &Option<(Pose, f64)>) -> fmt::Result {
    match nearest {
        Some((pose, cells)) => write!(f, "; {what} {pose}, {cells:.1} cells away"),
        None => write!(f, "; no pose has room"),
    }
}

/// A reason that the map alone gives, regardless of counts.
pub(crate) fn from_map(problem: &Problem, reach: &Reach) -> Option<Reason> {
    if problem.informative.is_empty() && problem.is_goal(problem.start()) {
        return None;
    }
    let lattice = problem.lattice();
    if problem.arcs(lattice.number(problem.start())).next().is_none() {
        let is_usable: Vec<bool> =
            (0..lattice.poses()).map(|pose| problem.arcs(pose).next().is_some()).collect();
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
    let (mut somewhere, mut within, mut on_the_way) =
        (vec![None; slots], vec![false; slots], vec![false; slots]);
    for (pose, &reached) in reached.iter().enumerate() {
        for arc in problem.arcs(pose) {
            let Some(slot) = problem.moves[arc.step as usize].slot.map(|slot| slot as usize) else {
                continue;
            };
            somewhere[slot].get_or_insert(problem.lattice().pose(pose));
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
    Some(Reason::FitsNowhere { action, name, elsewhere: somewhere[slot] })
}

/// The pose among `candidates` nearest to any of `targets`; of several one in the target's layer, then the first.
fn nearest(problem: &Problem, candidates: &[bool], targets: &[Pose]) -> Option<(Pose, f64)> {
    let poses =
        (0..candidates.len()).filter(|&pose| candidates[pose]).map(|pose| problem.lattice().pose(pose));
    let distance = |pose: Pose, target: &Pose| {
        let (di, dj) = (pose.i.abs_diff(target.i) as f64, pose.j.abs_diff(target.j) as f64);
        (libm::hypot(di, dj), pose.layer != target.layer)
    };
    let ranked = poses.flat_map(|pose| targets.iter().map(move |target| (distance(pose, target), pose)));
    let least = ranked.min_by(|(a, _), (b, _)| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)))?;
    Some((least.1, least.0.0))
}
