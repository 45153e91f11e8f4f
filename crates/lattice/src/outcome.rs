use crate::{Cost, Pose, Reason};

/// Which search to use.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Engine {
    /// Exhaustive where that is sensible and fits in memory, otherwise Lagrangian.
    #[default]
    Auto,
    /// Every state in order of cost. Proves everything, needs memory for all states.
    Exhaustive,
    /// Bounds from priced counts, a beam for plans, A* for the proof. Needs memory for what it looks at.
    Lagrangian,
}

/// How to search.
#[derive(Clone, Debug, PartialEq)]
pub struct Options {
    /// Which search to use.
    pub engine: Engine,
    /// Memory that the search may take \[bytes\], besides the problem itself.
    pub memory_bytes: u64,
    /// Steps of work (states looked at, about) between two questions whether to go on.
    pub poll_every: u64,
}

impl Default for Options {
    fn default() -> Self {
        Self { engine: Engine::Auto, memory_bytes: 4 << 30, poll_every: 1 << 16 }
    }
}

/// How far a search has come.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Progress {
    /// Work done, in states looked at, about.
    pub work: u64,
    /// No plan is cheaper than this.
    pub lower_bound: Cost,
    /// Cost of the best plan so far.
    pub best: Option<Cost>,
}

/// Why a search ended without a plan.
#[derive(Clone, Debug, PartialEq)]
pub enum NoPlan {
    /// No plan exists: proved.
    Infeasible(Reason),
    /// Told to stop before any plan was found.
    OutOfTime {
        /// No plan is cheaper than this.
        lower_bound: Cost,
    },
    /// The memory was used up before any plan was found.
    OutOfMemory {
        /// No plan is cheaper than this.
        lower_bound: Cost,
    },
    /// The exhaustive search was asked for and does not fit in the memory.
    TooLarge {
        /// Number of states.
        states: u128,
        /// Memory that it would take \[bytes\].
        bytes: u128,
    },
}

/// Why a search stopped before the proof.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Limit {
    /// It was told to stop.
    Time,
    /// The memory was used up.
    Memory,
}

/// What is known of a plan.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    /// No plan is cheaper: proved.
    Optimal,
    /// The plan is valid; the lower bound says how much cheaper another one might be.
    Feasible {
        /// Why there is no proof.
        stopped_by: Limit,
    },
}

/// A plan.
#[derive(Clone, Debug, PartialEq)]
pub struct Solution {
    /// What is known of it.
    pub status: Status,
    /// Its cost, the sum of its steps'.
    pub cost: Cost,
    /// No plan is cheaper than this. Equals the cost of an optimal plan. Of a feasible one the secondary part means
    /// something only where the primary parts are equal.
    pub lower_bound: Cost,
    /// What to do, in order.
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
