use std::fmt;

use crate::lattice::{Cost, Pose};

/// How to search.
#[derive(Clone, Debug, PartialEq)]
pub struct Options {
    /// Most memory of the search \[bytes\], besides the problem itself.
    pub memory_bytes: u64,
    /// Steps of work (approximate number of visited states) between two polls.
    pub poll_every: u64,
}

impl Default for Options {
    fn default() -> Self {
        Self { memory_bytes: 4 << 30, poll_every: 1 << 16 }
    }
}

/// The progress of a search.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Progress {
    /// Work done, as the approximate number of visited states.
    pub work: u64,
    /// No plan is cheaper than this.
    pub lower_bound: Cost,
}

/// Why a search ended without a plan.
#[derive(Clone, Debug, PartialEq)]
pub enum NoPlan {
    /// No plan exists: proved.
    Infeasible(Reason),
    /// Cancelled before any plan was found.
    OutOfTime {
        /// No plan is cheaper than this.
        lower_bound: Cost,
    },
    /// The memory was exhausted before any plan was found.
    OutOfMemory {
        /// No plan is cheaper than this.
        lower_bound: Cost,
    },
    /// The search does not fit in the memory.
    TooLarge {
        /// Number of states.
        states: u128,
        /// Memory that it would need \[bytes\].
        bytes: u128,
    },
}

/// Why a search stopped before the proof.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Limit {
    /// It was cancelled.
    Time,
    /// The memory was exhausted.
    Memory,
}

/// What is proved about a plan.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    /// No plan is cheaper: proved.
    Optimal,
    /// The plan is valid; the lower bound limits how much cheaper another one might be.
    Feasible {
        /// Why there is no proof.
        stopped_by: Limit,
    },
}

/// A plan.
#[derive(Clone, Debug, PartialEq)]
pub struct Solution {
    /// What is proved about it.
    pub status: Status,
    /// Its cost, the sum of its steps'.
    pub cost: Cost,
    /// No plan is cheaper than this. Equals the cost of an optimal plan. For a feasible one the secondary
    /// part is meaningful only where the primary parts are equal.
    pub lower_bound: Cost,
    /// The steps, in order.
    pub steps: Vec<Step>,
}

impl Solution {
    /// How much cheaper another plan might be, in the primary cost.
    pub fn gap(&self) -> f64 {
        (self.cost.primary - self.lower_bound.primary).max(0.0)
    }
}

/// One step of a plan.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Step {
    /// Index of the action.
    pub action: usize,
    /// Index among the action's moves with the layer of `from`.
    pub variant: usize,
    /// Where it starts.
    pub from: Pose,
    /// Where it ends.
    pub to: Pose,
    /// What it costs.
    pub cost: Cost,
}

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
        /// Counts that can be had, as many uses in total as any, by informative action; known after an exhaustive search.
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
