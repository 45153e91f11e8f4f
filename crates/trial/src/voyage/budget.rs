//! Whether chart and lattice fit in the memory, told before anything of that size is allocated.

use lattice::{Demand, Lattice};

use super::error::VoyageError;
use super::footing::Footing;
use super::moves::Moves;
use super::prepared::Prepared;
use super::search::Search;

impl Prepared {
    /// Refuses what does not fit in the memory; else the search with what the rasters leave of it.
    pub(super) fn within<'a>(&self, moves: &Moves, search: &Search<'a>) -> Result<Search<'a>, VoyageError> {
        let (task, grid) = (&self.brief.task, &self.grid);
        let raster = task.raster(grid);
        let (kinds, _) = self.obstacle_kinds();
        let cells = |(_, margin_m, _): &(f64, f64, bool)| {
            let around = 2 * ((margin_m / raster.cell_m).ceil() as u128 + 1);
            (raster.nx as u128 + around) * (raster.ny as u128 + around)
        };
        let lattice = Lattice { nx: grid.nx, ny: grid.ny, layers: grid.layers() };
        let masks = usize::from(!task.area.corners.is_empty()) + task.speed_limits.len();
        let cells = kinds.iter().map(cells).sum::<u128>() + (masks * raster.nx * raster.ny) as u128;
        let footing = Footing { lattice: Demand::new(lattice, &moves.actions), cells };
        if footing.bytes() > u128::from(search.options.memory_bytes) {
            return Err(VoyageError::TooLarge(footing));
        }
        let mut left = search.clone();
        left.options.memory_bytes -= footing.kept_bytes() as u64;
        Ok(left)
    }
}
