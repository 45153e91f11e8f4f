//! The memory that a lattice needs, before any state has been visited.

use crate::lattice::graph::WITHIN_PER_POSE;
use crate::lattice::{Action, Lattice};

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
