//! Exact planning on a state lattice whose maneuvers must be used a given number of times.
//!
//! A state is a pose (cell and layer) and how often each *informative* action has been used. A plan leads from the start to a
//! goal, uses every informative action exactly as often as required and basic actions any number of times, at the least cost;
//! costs are compared by their primary part, then by their secondary part. [`plan`] finds such a plan and says what is proved
//! about it; [`front`] gives the least cost of every count vector.
//!
//! The search is exhaustive: it visits all states in order of cost (all count vectors of a pose at once, as bits, where
//! costs allow it). "Optimal" always means proved. Where time or memory end it, a narrow beam may still find a plan. Costs are
//! read to 1e-9.
//!
//! [`ProblemFile`] is the file `experiment-lattice-planning/1`; [`FreeCells`] says where swept boxes are free.

mod beam;
mod dense;
mod file;
mod graph;
mod grid;
#[cfg(test)]
mod laws;
mod layered;
mod layout;
mod outcome;
mod plan;
mod problem;
#[cfg(test)]
#[path = "../../tests/all/lattice/seconds.rs"]
mod seconds;
#[cfg(test)]
#[path = "../../tests/all/lattice/synthetic.rs"]
mod synthetic;
mod watch;

pub use file::{BasicFile, FreeCells, InformativeFile, LatticeFile, MoveFile, ProblemFile, SCHEMA, SchemaId};
pub use graph::Demand;
pub(crate) use graph::{KeyOf, WaysOut};
pub use grid::{Action, Cost, Goal, Lattice, Move, MoveId, Pose};
pub use outcome::{Limit, NoPlan, Options, Progress, Reason, Solution, Status, Step};
pub use plan::{FrontPoint, front, plan};
pub use problem::Problem;
pub use refusal::Invalid;
pub use watch::Poll;
pub(crate) use watch::Watch;
