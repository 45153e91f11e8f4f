//! The part of a grid that covers the chart's area, on the plane.

use crate::{Bounds, Grid, GridCell, Invalid, Plane};

/// Points of the area's edge that are looked at to find the part of a grid that covers it, per side.
const PER_SIDE: usize = 32;

/// A window of a grid: cells row by row from the south, and the places of their corners.
#[derive(Clone, Debug)]
pub struct PlacedGrid {
    /// Columns of the window.
    pub columns: usize,
    /// Rows of the window.
    pub rows: usize,
    /// What is known of the cells, row by row from the south.
    pub cells: Vec<GridCell>,
    /// Places of the corners \[m\], `columns + 1` to a row, row by row from the south.
    pub corners: Vec<[f64; 2]>,
    /// Whether it tells depths (not only land).
    pub has_depth: bool,
}

impl PlacedGrid {
    /// `None` where the grid does not meet the area.
    pub(crate) fn place(grid: &Grid, plane: &Plane, area: &Bounds) -> Result<Option<Self>, Invalid> {
        if grid.columns.checked_mul(grid.rows) != Some(grid.cells.len())
            || grid.cell.is_nan()
            || grid.cell <= 0.0
        {
            let found = format!("{} cells of {} × {}", grid.cells.len(), grid.columns, grid.rows);
            return Err(Invalid::new(
                "grid",
                found,
                "columns × rows cells of a positive size",
                "read it from a file",
            ));
        }
        let Some([columns, rows]) = window(grid, plane, area)? else { return Ok(None) };
        let corners = corners(grid, plane, &columns, &rows)?;
        let row = |j: usize| &grid.cells[j * grid.columns..][columns.clone()];
        Ok(Some(Self {
            columns: columns.len(),
            rows: rows.len(),
            cells: rows.clone().flat_map(row).copied().collect(),
            corners,
            has_depth: grid.has_depth,
        }))
    }

    /// The outline, counter-clockwise.
    pub(crate) fn frame(&self) -> Vec<[f64; 2]> {
        self.strip(0..self.columns, 0..self.rows)
    }

    /// The outline of a block of cells, counter-clockwise, with all corners on it.
    pub(crate) fn strip(
        &self,
        columns: std::ops::Range<usize>,
        rows: std::ops::Range<usize>,
    ) -> Vec<[f64; 2]> {
        let corner = |i: usize, j: usize| self.corners[j * (self.columns + 1) + i];
        let south = columns.clone().map(|i| corner(i, rows.start));
        let east = rows.clone().map(|j| corner(columns.end, j));
        let north = columns.clone().rev().map(|i| corner(i + 1, rows.end));
        let west = rows.clone().rev().map(|j| corner(columns.start, j + 1));
        south.chain(east).chain(north).chain(west).collect()
    }
}

fn corners(
    grid: &Grid,
    plane: &Plane,
    columns: &std::ops::Range<usize>,
    rows: &std::ops::Range<usize>,
) -> Result<Vec<[f64; 2]>, Invalid> {
    let mut corners = Vec::with_capacity((columns.len() + 1) * (rows.len() + 1));
    for j in rows.start..=rows.end {
        for i in columns.start..=columns.end {
            let own = [grid.corner[0] + i as f64 * grid.cell, grid.corner[1] + j as f64 * grid.cell];
            let (lon, lat) = grid.crs.to_geographic(own)?;
            corners.push(plane.to_plane(lon, lat));
        }
    }
    Ok(corners)
}

/// Columns and rows that cover the area, with two cells to spare.
fn window(grid: &Grid, plane: &Plane, area: &Bounds) -> Result<Option<[std::ops::Range<usize>; 2]>, Invalid> {
    let own = |p: [f64; 2]| {
        let (lon, lat) = plane.to_geographic(p);
        let [x, y] = grid.crs.to_own(lon, lat)?;
        // Longitudes as the grid has them: -179 or 181.
        let middle = grid.corner[0] + grid.cell * grid.columns as f64 / 2.0;
        let turn = if grid.crs.is_geographic() { 360.0 * ((x - middle) / 360.0).round() } else { 0.0 };
        Ok([x - turn, y])
    };
    let edge = area.edge(PER_SIDE).into_iter().map(own).collect::<Result<Vec<_>, Invalid>>()?;
    let Some(around) = Bounds::around(&edge) else { return Ok(None) };
    let range = |k: usize, count: usize| {
        let low = ((around.min[k] - grid.corner[k]) / grid.cell).floor() - 2.0;
        let high = ((around.max[k] - grid.corner[k]) / grid.cell).ceil() + 2.0;
        low.clamp(0.0, count as f64) as usize..high.clamp(0.0, count as f64) as usize
    };
    let ranges = [range(0, grid.columns), range(1, grid.rows)];
    Ok((!ranges[0].is_empty() && !ranges[1].is_empty()).then_some(ranges))
}
