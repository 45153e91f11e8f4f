//! What chart and lattice take in memory.

use std::fmt;

use lattice::Demand;

/// Bytes of a raster cell while obstacles are found, about: causes, distances, what is charted; and of what is kept.
const PER_CELL: u128 = 26;
const KEPT_PER_CELL: u128 = 10;

/// What a search stands on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Footing {
    /// Poses and moves of the lattice.
    pub lattice: Demand,
    /// Cells of all rasters of obstacles.
    pub cells: u128,
}

impl Footing {
    /// Bytes that it takes at most, about.
    pub fn bytes(&self) -> u128 {
        let rasters = self.cells.saturating_mul(PER_CELL);
        rasters.max(self.kept_bytes().saturating_add(self.lattice.bytes()))
    }

    /// Bytes of rasters that stay while the lattice is searched.
    pub(super) fn kept_bytes(&self) -> u128 {
        self.cells.saturating_mul(KEPT_PER_CELL)
    }
}

impl fmt::Display for Footing {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Demand { poses, moves } = self.lattice;
        let mib = self.bytes().div_ceil(1 << 20);
        write!(
            f,
            "{poses} poses with up to {moves} moves and {} raster cells, which take {mib} MiB",
            self.cells
        )
    }
}
