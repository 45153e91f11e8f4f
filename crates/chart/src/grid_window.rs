//! The columns and rows of a grid that cover an area, and their memory.

use std::ops::Range;

use crate::grid_header::Header;
use crate::{Bounds, Crs, Invalid, Plane};

/// Columns from the west and rows from the south.
pub(crate) type Block = [Range<usize>; 2];

/// Points per side of the area's edge that are projected to find the part of a grid that covers it.
const PER_SIDE: usize = 32;

/// Most cells whose corners are kept rather than computed on demand.
pub(crate) const MOST_KEPT: usize = 4_000_000;
/// Bytes of a cell, and of a corner that is kept.
const CELL_BYTES: f64 = 4.0;
const CORNER_BYTES: f64 = 16.0;

/// Bytes of a window of so many cells, with its kept corners.
pub(crate) fn bytes_of(cells: f64) -> f64 {
    let corners = if cells > MOST_KEPT as f64 { 0.0 } else { CORNER_BYTES };
    cells * (CELL_BYTES + corners)
}

/// Columns and rows that cover the area, with two cells to spare.
pub(crate) fn window(
    grid: &Header,
    crs: &Crs,
    plane: &Plane,
    area: &Bounds,
) -> Result<Option<Block>, Invalid> {
    let own = |p: [f64; 2]| {
        let (lon, lat) = plane.to_geographic(p);
        let [x, y] = crs.to_own(lon, lat)?;
        // Longitudes in the grid's range: -179 or 181.
        let centre = grid.corner[0] + grid.cell * grid.columns as f64 / 2.0;
        let turn = if crs.is_geographic() { 360.0 * ((x - centre) / 360.0).round() } else { 0.0 };
        Ok([x - turn, y])
    };
    let edge = area.edge(PER_SIDE).into_iter().map(own).collect::<Result<Vec<_>, Invalid>>()?;
    let Some(needed) = Bounds::enclosing(&edge) else { return Ok(None) };
    let range = |k: usize, count: usize| {
        let low = ((needed.min[k] - grid.corner[k]) / grid.cell).floor() - 2.0;
        let high = ((needed.max[k] - grid.corner[k]) / grid.cell).ceil() + 2.0;
        low.clamp(0.0, count as f64) as usize..high.clamp(0.0, count as f64) as usize
    };
    let ranges = [range(0, grid.columns), range(1, grid.rows)];
    Ok((!ranges[0].is_empty() && !ranges[1].is_empty()).then_some(ranges))
}
