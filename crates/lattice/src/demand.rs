//! What a lattice takes before any state has been looked at.

use crate::{Action, Lattice};

/// Bytes of a pose in the graph's and a search's tables together, about.
const PER_POSE: u128 = 28;
/// Bytes of an allowed move, about: a bit in the problem, and once in the tables of a search.
const PER_MOVE: u128 = 10;

/// What a lattice with its moves takes, told before anything is allocated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Demand {
    /// Poses.
    pub poses: u128,
    /// Moves that stay in the lattice, over all poses: as many as are allowed where nothing is in the way.
    pub moves: u128,
}

impl Demand {
    /// Of a lattice with these actions.
    pub fn new(lattice: Lattice, actions: &[Action]) -> Self {
        let Lattice { nx, ny, layers } = lattice;
        let left = |count: usize, step: i32| count.saturating_sub(step.unsigned_abs() as usize) as u128;
        let moves = actions.iter().flat_map(|action| &action.moves);
        let moves = moves.map(|step| left(nx, step.di).saturating_mul(left(ny, step.dj)));
        let poses = [ny, layers].into_iter().fold(nx as u128, |all, n| all.saturating_mul(n as u128));
        Self { poses, moves: moves.fold(0, u128::saturating_add) }
    }

    /// Bytes that problem, graph and the arcs of a search take at most, about; its states take more.
    pub fn bytes(&self) -> u128 {
        let poses = self.poses.saturating_mul(PER_POSE);
        poses.saturating_add(self.moves.saturating_mul(PER_MOVE))
    }

    /// Bytes of the problem that stay when its search is over, about: a bit for each move.
    pub fn kept_bytes(&self) -> u128 {
        self.moves / 8
    }
}
