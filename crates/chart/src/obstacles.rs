use crate::distance::squared_gaps;
use crate::occupancy::{Occupancy, Sailing};
use crate::raster::MOST_CELLS;
use crate::{Causes, Chart, Footprint, Invalid, Mask, Raster};

/// Where the ship may not be: blocked cells of a raster, and the distance to what blocks them.
///
/// A cell is an *obstacle* when any part of it is land, no-go, shoaler than the least depth, or not
/// charted. It is *blocked* when the least distance between any of its points and any point of an obstacle
/// cell is below the margin. So a free cell keeps all its points at least the margin away from everything
/// charted; because whole cells are compared, up to one diagonal of the obstacle's cell and one of its own
/// more than that may be kept (70 m in all at 25 m).
#[derive(Clone, Debug)]
pub struct Obstacles {
    raster: Raster,
    causes: Vec<Causes>,
    gap_m: Vec<f32>,
    blocked: Mask,
}

impl Obstacles {
    /// Obstacles of a chart for a least depth \[m\] and a margin \[m\], for informative maneuvers: what these keep out
    /// of, too. A greater least depth and a greater margin only add blocked cells.
    ///
    /// Obstacles up to the margin outside the raster are seen. The least depth does not matter to charts of
    /// land only.
    ///
    /// # Errors
    /// A raster without cells or with too many (its margin included); a least depth or margin that is not
    /// finite; a negative margin.
    pub fn new(chart: &Chart, raster: Raster, least_depth_m: f64, margin_m: f64) -> Result<Self, Invalid> {
        Self::of(chart, raster, [least_depth_m, margin_m], Sailing::Maneuvers)
    }

    /// The same for getting about, which areas that are kept free of maneuvers ([`crate::Class::TransitOnly`]) do not hinder.
    ///
    /// # Errors
    /// As [`Obstacles::new`].
    pub fn in_transit(
        chart: &Chart,
        raster: Raster,
        least_depth_m: f64,
        margin_m: f64,
    ) -> Result<Self, Invalid> {
        Self::of(chart, raster, [least_depth_m, margin_m], Sailing::Transit)
    }

    fn of(chart: &Chart, raster: Raster, limits: [f64; 2], sailing: Sailing) -> Result<Self, Invalid> {
        let [least_depth_m, margin_m] = limits;
        raster.check()?;
        let pad = check(&raster, least_depth_m, margin_m)?;
        let wide = raster.padded(pad);
        let occupancy = Occupancy::of(chart, wide, least_depth_m, sailing);
        let set: Vec<bool> = occupancy.causes.iter().map(|c| c.any()).collect();
        let squared = squared_gaps(&set, wide.nx);
        let cells = raster.nx * raster.ny;
        let (mut causes, mut gap_m) = (Vec::with_capacity(cells), Vec::with_capacity(cells));
        let mut blocked = Vec::with_capacity(cells);
        let reach = (margin_m / raster.cell_m).powi(2);
        for row in 0..raster.ny {
            let from = (row + pad) * wide.nx + pad;
            causes.extend(&occupancy.causes[from..from + raster.nx]);
            for (col, gap) in squared[from..from + raster.nx].iter().enumerate() {
                let obstacle = set[from + col];
                blocked.push(obstacle || *gap < reach);
                let edge = edge_gap(&raster, pad, col, row);
                let cells = if obstacle { 0.0 } else { gap.sqrt().min(edge) };
                gap_m.push(round_down(cells * raster.cell_m));
            }
        }
        Ok(Self { raster, causes, gap_m, blocked: Mask::new(raster, blocked) })
    }

    /// The raster.
    pub fn raster(&self) -> Raster {
        self.raster
    }

    /// Whether a cell is blocked, the margin included; cells off the raster are.
    pub fn is_blocked(&self, col: usize, row: usize) -> bool {
        self.index(col, row).is_none_or(|k| self.blocked.closed()[k])
    }

    /// What makes a cell an obstacle, the margin left aside; `NONE` for cells that are free or blocked by
    /// the margin only.
    pub fn causes(&self, col: usize, row: usize) -> Causes {
        self.index(col, row).map_or(Causes::UNCHARTED, |k| self.causes[k])
    }

    /// Blocked cells, row by row from the south: `nx · ny` entries.
    pub fn blocked(&self) -> &[bool] {
        self.blocked.closed()
    }

    /// Clearance \[m\]: the ship can go this far from the point's cell, in any direction, without meeting
    /// an obstacle cell (margin left aside) or the edge of what was looked at, the margin outside the
    /// raster. Never more than the true distance; 0 on obstacles and off the raster.
    pub fn distance_m(&self, x: f64, y: f64) -> f64 {
        let cell = self.raster.cell_at([x, y]);
        cell.and_then(|(col, row)| self.index(col, row)).map_or(0.0, |k| f64::from(self.gap_m[k]))
    }

    /// Whether a footprint put on node (col, row) covers free cells only. Off the raster is blocked, as is
    /// a footprint of another cell size. Takes one look-up per run.
    pub fn is_free(&self, footprint: &Footprint, col: usize, row: usize) -> bool {
        self.blocked.is_free(footprint, col, row)
    }

    fn index(&self, col: usize, row: usize) -> Option<usize> {
        (col < self.raster.nx && row < self.raster.ny).then(|| row * self.raster.nx + col)
    }
}

/// Number of cells that the raster is widened by, so that obstacles up to the margin outside are seen.
fn check(raster: &Raster, least_depth_m: f64, margin_m: f64) -> Result<usize, Invalid> {
    let refuse = |thing: &str, found: String| {
        Invalid::new(
            thing,
            found,
            "finite metres, a margin of 0 or more, and a raster that still fits",
            "correct it",
        )
    };
    if !least_depth_m.is_finite() {
        return Err(refuse("least depth", least_depth_m.to_string()));
    }
    let cells = (margin_m / raster.cell_m).ceil() + 1.0;
    let wide = (raster.nx as f64 + 2.0 * cells) * (raster.ny as f64 + 2.0 * cells);
    if margin_m >= 0.0 && wide <= MOST_CELLS as f64 {
        return Ok(cells as usize);
    }
    Err(refuse("margin", format!("{margin_m} m at {} m per cell", raster.cell_m)))
}

/// Gap in cells between a cell and the outside of the widened raster.
fn edge_gap(raster: &Raster, pad: usize, col: usize, row: usize) -> f64 {
    let near = col.min(raster.nx - 1 - col).min(row).min(raster.ny - 1 - row);
    (near + pad) as f64
}

/// The nearest single-precision number that is not greater.
fn round_down(value: f64) -> f32 {
    let near = value as f32;
    if f64::from(near) > value { near.next_down() } else { near }
}
