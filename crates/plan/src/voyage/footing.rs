//! The memory of chart, lattice and check.

use std::fmt;

use crate::lattice::Demand;
use chart::Distances;

/// Approximate bytes of a raster cell while obstacles are computed: causes, gaps of rows, distances; and of
/// its distance alone.
const PER_CELL: u128 = 16;
const KEPT_PER_CELL: u128 = 10;

/// The memory of a search and its check.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Footing {
    /// Poses and moves of the lattice.
    pub lattice: Demand,
    /// Cells of all rasters of obstacles.
    pub cells: u128,
    /// Cells of the rasters that clearances are measured on.
    pub clearance_cells: u128,
    /// Bytes of the chart, of legs and of the inputs.
    pub other: u128,
    /// Bytes of the check of a plan, and of its output.
    pub check: u128,
}

impl Footing {
    /// Approximate bytes at most.
    pub fn bytes(&self) -> u128 {
        let rasters = self.standing().saturating_add(self.cells.saturating_mul(PER_CELL));
        let checked = self.lattice.kept_bytes().saturating_add(self.check);
        let searched = self.lattice.bytes().max(checked);
        let searched = self.kept_bytes().saturating_add(searched);
        rasters.max(searched)
    }

    /// Bytes that remain while the lattice is searched.
    pub(super) fn kept_bytes(&self) -> u128 {
        self.standing().saturating_add(self.cells.saturating_mul(KEPT_PER_CELL))
    }

    /// Bytes that remain from round to round. The allocator keeps the memory for computing clearances for a
    /// while.
    fn standing(&self) -> u128 {
        let clearances = self.clearance_cells.saturating_mul(Distances::FOUND_BYTES.into());
        self.other.saturating_add(clearances)
    }
}

impl fmt::Display for Footing {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Demand { poses, moves } = self.lattice;
        let cells = self.cells + self.clearance_cells;
        write!(f, "{poses} poses with up to {moves} moves and {cells} raster cells")
    }
}
