//! The part of a grid that covers the chart's area, on the plane.

use std::ops::Range;
use std::sync::Arc;

use crate::grid_header::Header;
use crate::grid_window::{Block, MOST_KEPT, window};
use crate::{Bounds, Crs, Grid, GridCell, Invalid, Plane};

/// Corners on a side of a block of cells whose corners are not kept: a side between two of them is nearly
/// straight.
const PER_BLOCK: usize = 64;

/// A window of a grid: cells row by row from the south, and the positions of their corners.
#[derive(Clone, Debug)]
pub struct PlacedGrid {
    /// Columns of the window.
    pub columns: usize,
    /// Rows of the window.
    pub rows: usize,
    /// Whether it has depths (and not only land).
    pub has_depth: bool,
    cells: Arc<[f32]>,
    corners: Corners,
}

/// The positions of corners of cells \[m\].
#[derive(Clone, Debug)]
enum Corners {
    /// `columns + 1` to a row, row by row from the south.
    Kept(Vec<[f64; 2]>),
    /// Computed on demand, for a window with too many cells.
    Found(Box<Frame>),
}

/// The position of a window in its grid.
#[derive(Clone, Debug)]
struct Frame {
    crs: Crs,
    plane: Plane,
    corner: [f64; 2],
    cell: f64,
    /// The first column and row of the window.
    first: [usize; 2],
}

impl Frame {
    fn corner(&self, column: usize, row: usize) -> Result<[f64; 2], Invalid> {
        let index = [self.first[0] + column, self.first[1] + row];
        let own = [0, 1].map(|k: usize| self.corner[k] + index[k] as f64 * self.cell);
        let (lon, lat) = self.crs.to_geographic(own)?;
        Ok(self.plane.to_plane(lon, lat))
    }
}

impl PlacedGrid {
    /// `None` where the grid does not meet the area.
    pub(crate) fn place(grid: &Grid, plane: &Plane, area: &Bounds) -> Result<Option<Self>, Invalid> {
        let [kept_columns, kept_rows] = &grid.window;
        let within = kept_columns.end <= grid.columns && kept_rows.end <= grid.rows;
        if kept_columns.len().checked_mul(kept_rows.len()) != Some(grid.cells.len())
            || !within
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
        let (corner, cell) = (grid.corner, grid.cell);
        let header = Header { columns: grid.columns, rows: grid.rows, corner, cell };
        let Some(wanted) = window(&header, &grid.crs, plane, area)? else { return Ok(None) };
        let [columns, rows] =
            [0, 1].map(|k| wanted[k].start.max(grid.window[k].start)..wanted[k].end.min(grid.window[k].end));
        if columns.is_empty() || rows.is_empty() {
            return Ok(None);
        }
        let first = [columns.start, rows.start];
        let frame = Frame { crs: grid.crs.clone(), plane: *plane, corner, cell, first };
        let corners = Corners::of(frame, columns.len(), rows.len())?;
        let (nx, ny, has_depth) = (columns.len(), rows.len(), grid.has_depth);
        Ok(Some(Self { columns: nx, rows: ny, cells: grid.part([columns, rows]), corners, has_depth }))
    }

    /// Approximate bytes of memory.
    pub(crate) fn bytes(&self) -> usize {
        let kept = if let Corners::Kept(corners) = &self.corners { size_of_val(&corners[..]) } else { 0 };
        size_of_val(&self.cells[..]) + kept
    }

    /// The values of a row from the south, as [`Grid`] keeps them.
    pub(crate) fn row(&self, row: usize) -> &[f32] {
        &self.cells[row * self.columns..(row + 1) * self.columns]
    }

    /// The content of a cell.
    pub(crate) fn cell(&self, column: usize, row: usize) -> GridCell {
        GridCell::of(self.row(row)[column], self.has_depth)
    }

    /// The position of a corner \[m\]; `None` outside of the projection's domain.
    pub(crate) fn corner(&self, column: usize, row: usize) -> Option<[f64; 2]> {
        match &self.corners {
            Corners::Kept(corners) => corners.get(row * (self.columns + 1) + column).copied(),
            Corners::Found(frame) => frame.corner(column, row).ok(),
        }
    }

    /// The outline, counter-clockwise.
    pub(crate) fn frame(&self) -> Option<Vec<[f64; 2]>> {
        self.strip(0..self.columns, 0..self.rows)
    }

    /// The outline of a block of cells, counter-clockwise, with all corners on it, or enough of them to
    /// follow its curvature; `None` outside of the projection's domain.
    pub(crate) fn strip(&self, columns: Range<usize>, rows: Range<usize>) -> Option<Vec<[f64; 2]>> {
        let step = |range: &Range<usize>| match self.corners {
            Corners::Kept(_) => 1,
            Corners::Found(_) => range.len().div_ceil(PER_BLOCK).max(1),
        };
        let (across, up) = (step(&columns), step(&rows));
        let south = columns.clone().step_by(across).map(|i| (i, rows.start));
        let east = rows.clone().step_by(up).map(|j| (columns.end, j));
        let north = columns.clone().map(|i| i + 1).rev().step_by(across).map(|i| (i, rows.end));
        let west = rows.clone().map(|j| j + 1).rev().step_by(up).map(|j| (columns.start, j));
        south.chain(east).chain(north).chain(west).map(|(i, j)| self.corner(i, j)).collect()
    }
}

impl Corners {
    /// Keeps the corners of all cells, unless there are too many: then only the outline is checked.
    fn of(frame: Frame, columns: usize, rows: usize) -> Result<Self, Invalid> {
        if columns * rows > MOST_KEPT {
            let outline = (0..=columns).flat_map(|i| [(i, 0), (i, rows)]);
            let outline = outline.chain((0..=rows).flat_map(|j| [(0, j), (columns, j)]));
            for (column, row) in outline {
                frame.corner(column, row)?;
            }
            return Ok(Self::Found(Box::new(frame)));
        }
        let all = (0..=rows).flat_map(|j| (0..=columns).map(move |i| (i, j)));
        Ok(Self::Kept(all.map(|(i, j)| frame.corner(i, j)).collect::<Result<_, _>>()?))
    }
}

impl Grid {
    /// The values of a part of the window.
    fn part(&self, part: Block) -> Arc<[f32]> {
        if part == self.window {
            return Arc::clone(&self.cells);
        }
        let ([columns, rows], [own_columns, own_rows]) = (part, &self.window);
        let row = |j: usize| {
            let start = (j - own_rows.start) * own_columns.len();
            let row = &self.cells[start..start + own_columns.len()];
            &row[columns.start - own_columns.start..columns.end - own_columns.start]
        };
        rows.flat_map(row).copied().collect()
    }
}
