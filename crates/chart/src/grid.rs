use std::sync::Arc;

pub(crate) use crate::grid_kind::FARTHEST;
use crate::grid_window::{Block, bytes_of};
use crate::{Crs, Measured};

/// The value of land in the cells of a mask.
pub(crate) const LAND: f32 = 1.0;

/// A grid of depths or land, as far as it was read. A value is valid for its whole cell.
#[derive(Clone, Debug)]
pub struct Grid {
    /// The system of its coordinates.
    pub crs: Crs,
    /// Whether it has depths (and not only land).
    pub has_depth: bool,
    /// Coordinates of the south-western corner, in the CRS.
    pub corner: [f64; 2],
    /// Side of a cell, in the CRS's unit.
    pub cell: f64,
    /// Columns, from west to east.
    pub columns: usize,
    /// Rows, from south to north (the file has them from north to south).
    pub rows: usize,
    /// Unit and datum of its depths; a land mask has none.
    pub measured: Option<Measured>,
    /// The columns and rows that are kept.
    pub(crate) window: Block,
    /// Per cell of the window, row by row from the south: depth \[m\], or 1 for land and 0 for water, or NaN
    /// without data.
    pub(crate) cells: Arc<[f32]>,
}

/// The content of one cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum GridCell {
    /// No data: not charted, an obstacle.
    Missing,
    /// Land, of a land mask.
    Land,
    /// Water of unknown depth, of a land mask.
    Water,
    /// Depth \[m\], positive down; negative: drying. To seven digits.
    Depth(f64),
}

impl Grid {
    /// Bytes of its cells and of their kept corners.
    pub fn bytes(&self) -> u64 {
        bytes_of(self.cells.len() as f64) as u64
    }

    /// The kept cells, row by row from the south.
    pub fn cells(&self) -> impl Iterator<Item = GridCell> {
        self.cells.iter().map(|value| GridCell::of(*value, self.has_depth))
    }
}

impl GridCell {
    /// The content of a kept value.
    pub(crate) fn of(value: f32, has_depth: bool) -> Self {
        match value {
            value if value.is_nan() => Self::Missing,
            value if has_depth => Self::Depth(decimal(value)),
            LAND => Self::Land,
            _ => Self::Water,
        }
    }
}

/// The shortest decimal number that is kept as `value`: the one in the file, if that has at most seven
/// digits.
fn decimal(value: f32) -> f64 {
    value.to_string().parse().unwrap_or(f64::from(value))
}
