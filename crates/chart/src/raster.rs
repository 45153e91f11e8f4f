use crate::{Bounds, Invalid};

/// Most cells of a raster.
pub(crate) const MOST_CELLS: usize = 200_000_000;

/// Square cells on the plane. Cell (0, 0) is the south-western one; columns run east, rows run north.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Raster {
    /// South-western corner of cell (0, 0) \[m\].
    pub origin: [f64; 2],
    /// Side of a cell \[m\].
    pub cell_m: f64,
    /// Columns.
    pub nx: usize,
    /// Rows.
    pub ny: usize,
}

impl Raster {
    /// The smallest raster from the box's south-western corner that covers it.
    ///
    /// # Errors
    /// A cell size that is not positive, or more than 2·10⁸ cells.
    pub fn covering(bounds: &Bounds, cell_m: f64) -> Result<Self, Invalid> {
        // Rounding must not add a cell to a box of whole cells.
        let count = |k: usize| ((bounds.max[k] - bounds.min[k]) / cell_m - 1e-9).ceil().max(1.0) as usize;
        let raster = Self { origin: bounds.min, cell_m, nx: count(0), ny: count(1) };
        raster.check()?;
        Ok(raster)
    }

    /// The box that the cells fill.
    pub fn bounds(&self) -> Bounds {
        Bounds { min: self.origin, max: self.node(self.nx, self.ny) }
    }

    /// Place of a node \[m\]: the south-western corner of cell (col, row).
    pub fn node(&self, col: usize, row: usize) -> [f64; 2] {
        [self.origin[0] + col as f64 * self.cell_m, self.origin[1] + row as f64 * self.cell_m]
    }

    /// Column and row of the cell that holds a point; `None` off the raster.
    pub fn cell_at(&self, [x, y]: [f64; 2]) -> Option<(usize, usize)> {
        let index = |v: f64, k: usize, count: usize| {
            // The conversion to an integer rounds down.
            let i = (v - self.origin[k]) / self.cell_m;
            (i >= 0.0 && i < count as f64).then_some(i as usize)
        };
        Some((index(x, 0, self.nx)?, index(y, 1, self.ny)?))
    }

    pub(crate) fn check(&self) -> Result<(), Invalid> {
        let finite = self.origin.iter().all(|v| v.is_finite()) && self.cell_m.is_finite();
        let cells = self.nx.checked_mul(self.ny).filter(|n| (1..=MOST_CELLS).contains(n));
        if finite && self.cell_m > 0.0 && cells.is_some() {
            return Ok(());
        }
        Err(Invalid::new(
            "raster",
            format!("{} × {} cells of {} m from {:?}", self.nx, self.ny, self.cell_m, self.origin),
            format!("1 to {MOST_CELLS} cells of a positive size"),
            "choose another cell size or area",
        ))
    }

    /// The raster with `by` more cells on every side.
    pub(crate) fn padded(&self, by: usize) -> Self {
        let back = by as f64 * self.cell_m;
        Self {
            origin: self.origin.map(|v| v - back),
            cell_m: self.cell_m,
            nx: self.nx + 2 * by,
            ny: self.ny + 2 * by,
        }
    }

    /// A point in units of cells from the origin.
    pub(crate) fn in_cells(&self, p: [f64; 2]) -> [f64; 2] {
        [(p[0] - self.origin[0]) / self.cell_m, (p[1] - self.origin[1]) / self.cell_m]
    }
}
