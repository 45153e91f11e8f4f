//! Cells of a raster that are closed to a hull, for any reason.

use crate::cover::{Size, along, centres, each_edge};
use crate::occupancy::TOUCH_M;
use crate::{Footprint, Polygon, Raster};

/// A raster of which some cells are closed.
#[derive(Clone, Debug)]
pub struct Mask {
    raster: Raster,
    closed: Vec<bool>,
    /// Per row, the number of closed cells before each column: `nx + 1` entries.
    before: Vec<u32>,
}

impl Mask {
    /// `closed`: cells row by row from the south, `nx · ny` of them.
    pub(crate) fn new(raster: Raster, closed: Vec<bool>) -> Self {
        let mut before = Vec::with_capacity(closed.len() + raster.ny);
        for row in closed.chunks(raster.nx) {
            let mut count = 0;
            before.push(count);
            for closed in row {
                count += u32::from(*closed);
                before.push(count);
            }
        }
        Self { raster, closed, before }
    }

    /// Closes every cell that any part of a polygon touches.
    pub fn within(polygon: &Polygon, raster: Raster) -> Self {
        let (edge, inside) = cells(polygon, raster);
        Self::new(raster, edge.iter().zip(inside).map(|(edge, inside)| *edge || inside).collect())
    }

    /// Closes every cell that is not entirely inside of a polygon.
    pub fn beyond(polygon: &Polygon, raster: Raster) -> Self {
        let (edge, inside) = cells(polygon, raster);
        Self::new(raster, edge.iter().zip(inside).map(|(edge, inside)| *edge || !inside).collect())
    }

    /// The raster.
    pub fn raster(&self) -> Raster {
        self.raster
    }

    /// Closed cells, row by row from the south: `nx · ny` entries.
    pub fn closed(&self) -> &[bool] {
        &self.closed
    }

    /// Whether a footprint at node (col, row) covers free cells only. Cells off the raster are closed, and a
    /// footprint of another cell size never fits. Takes one look-up per run.
    pub fn is_free(&self, footprint: &Footprint, col: usize, row: usize) -> bool {
        let same = footprint.cell_m() == self.raster.cell_m;
        same && footprint.runs().iter().all(|run| {
            let at = |node: usize, offset: i32| i64::try_from(node).ok()?.checked_add(i64::from(offset));
            let (Some(row), Some(first), Some(last)) =
                (at(row, run.row), at(col, run.first), at(col, run.last))
            else {
                return false;
            };
            self.row_is_free(row, first, last)
        })
    }

    fn row_is_free(&self, row: i64, first: i64, last: i64) -> bool {
        let Raster { nx, ny, .. } = self.raster;
        if row < 0 || row >= ny as i64 || first < 0 || last >= nx as i64 || first > last {
            return false;
        }
        let start = row as usize * (nx + 1);
        self.before[start + last as usize + 1] == self.before[start + first as usize]
    }
}

/// Cells that a polygon's edges touch, and those whose centre is inside.
fn cells(polygon: &Polygon, raster: Raster) -> (Vec<bool>, Vec<bool>) {
    let size = Size { nx: raster.nx, ny: raster.ny };
    let ring = |ring: &Vec<[f64; 2]>| ring.iter().map(|p| raster.in_cells(*p)).collect();
    let rings: Vec<Vec<[f64; 2]>> = polygon.rings.iter().map(ring).collect();
    let (mut edge, mut inside) = (vec![false; size.nx * size.ny], vec![false; size.nx * size.ny]);
    let fill = |cells: &mut Vec<bool>, row: usize, first: usize, last: usize| {
        cells[row * size.nx + first..=row * size.nx + last].fill(true);
    };
    each_edge(&rings, |a, b| {
        along(a, b, TOUCH_M / raster.cell_m, size, |row, first, last| fill(&mut edge, row, first, last));
    });
    centres(&rings, size, |row, first, last| fill(&mut inside, row, first, last));
    (edge, inside)
}
