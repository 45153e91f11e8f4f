use crate::lattice::{Cost, Pose, Reason};

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
