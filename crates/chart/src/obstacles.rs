use crate::distance::squared_gaps;
use crate::occupancy::{Activity, Occupancy};
use crate::raster::MOST_CELLS;
use crate::{Causes, Chart, Footprint, Invalid, Mask, Raster};

/// The distance of every cell of a raster to the nearest charted obstacle: the part of [`Obstacles`] that a
/// clearance needs.
#[derive(Clone, Debug)]
pub struct Distances {
    raster: Raster,
    gap_m: Vec<f32>,
}

impl Distances {
    /// Approximate bytes per cell, including those around the raster, while distances are computed.
    pub const FOUND_BYTES: u64 = 9;

    /// [`Obstacles::new`] for a least depth \[m\], with distances up to `sight_m`; `None` once `keep_going`
    /// returns false.
    ///
    /// # Errors
    /// As [`Obstacles::new`].
    pub fn new(
        chart: &Chart,
        raster: Raster,
        [least_depth_m, sight_m]: [f64; 2],
        keep_going: &dyn Fn() -> bool,
    ) -> Result<Option<Self>, Invalid> {
        Self::of(chart, raster, [least_depth_m, sight_m], Activity::Maneuvers, keep_going, |_, _| ())
    }

    /// [`Obstacles::in_transit`], in the same way.
    ///
    /// # Errors
    /// As [`Obstacles::new`].
    pub fn in_transit(
        chart: &Chart,
        raster: Raster,
        [least_depth_m, sight_m]: [f64; 2],
        keep_going: &dyn Fn() -> bool,
    ) -> Result<Option<Self>, Invalid> {
        Self::of(chart, raster, [least_depth_m, sight_m], Activity::Transit, keep_going, |_, _| ())
    }

    /// `each` is called with every cell's causes, and its squared gap to the nearest obstacle \[cells²\].
    fn of(
        chart: &Chart,
        raster: Raster,
        [least_depth_m, margin_m]: [f64; 2],
        activity: Activity,
        keep_going: &dyn Fn() -> bool,
        mut each: impl FnMut(Causes, f64),
    ) -> Result<Option<Self>, Invalid> {
        raster.check()?;
        let pad = check(&raster, least_depth_m, margin_m)?;
        let wide = raster.padded(pad);
        let causes = Occupancy::of(chart, wide, least_depth_m, activity).causes;
        let mut gap_m = Vec::with_capacity(raster.nx * raster.ny);
        let whole = squared_gaps(
            |k| causes[k].any(),
            [wide.nx, wide.ny],
            keep_going,
            |wide_row, squared| {
                let Some(row) = wide_row.checked_sub(pad).filter(|row| *row < raster.ny) else { return };
                let own = &causes[wide_row * wide.nx + pad..][..raster.nx];
                for (col, (cause, gap)) in own.iter().zip(&squared[pad..]).enumerate() {
                    let edge = edge_gap(&raster, pad, col, row);
                    let cells = if cause.any() { 0.0 } else { gap.sqrt().min(edge) };
                    gap_m.push(round_down(cells * raster.cell_m));
                    each(*cause, *gap);
                }
            },
        );
        Ok(whole.map(|()| Self { raster, gap_m }))
    }

    /// The raster.
    pub fn raster(&self) -> Raster {
        self.raster
    }

    /// Clearance \[m\]: the ship can go this far from the point's cell, in any direction, without meeting an
    /// obstacle cell (regardless of the margin) or the edge of the charted area, the margin outside the
    /// raster. Never more than the true distance; 0 on obstacles and off the raster.
    pub fn distance_m(&self, x: f64, y: f64) -> f64 {
        let cell = self.raster.cell_at([x, y]);
        cell.and_then(|(col, row)| self.index(col, row)).map_or(0.0, |k| f64::from(self.gap_m[k]))
    }

    /// The same between the centres of cells, interpolated linearly \[m\]: continuous, for searches that compare places. 0 off
    /// the raster.
    pub fn between_cells_m(&self, x: f64, y: f64) -> f64 {
        let Raster { nx, ny, .. } = self.raster;
        if self.raster.cell_at([x, y]).is_none() {
            return 0.0;
        }
        let [col, row] = self.raster.in_cells([x, y]);
        let [col, row] =
            [(col, nx), (row, ny)].map(|(own, count)| (own - 0.5).clamp(0.0, count as f64 - 1.0));
        let [west, south] = [col, row].map(|own| own as usize);
        let [east, north] = [(west + 1).min(nx - 1), (south + 1).min(ny - 1)];
        let at = |col: usize, row: usize| f64::from(self.gap_m[row * nx + col]);
        let part = col - west as f64;
        let [low, high] = [south, north].map(|row| (1.0 - part) * at(west, row) + part * at(east, row));
        let part = row - south as f64;
        (1.0 - part) * low + part * high
    }

    fn index(&self, col: usize, row: usize) -> Option<usize> {
        (col < self.raster.nx && row < self.raster.ny).then(|| row * self.raster.nx + col)
    }
}

/// The area that is closed to the ship: blocked cells of a raster, and the distance to what blocks them.
///
/// A cell is an *obstacle* when any part of it is land, no-go, shoaler than the least depth, or not
/// charted. It is *blocked* when the least distance between any of its points and any point of an obstacle
/// cell is below the margin. So a free cell keeps all its points at least the margin away from everything
/// charted; because whole cells are compared, the kept distance may be larger by up to one diagonal of the
/// obstacle's cell and one of its own (70 m in all at 25 m).
#[derive(Clone, Debug)]
pub struct Obstacles {
    distances: Distances,
    causes: Vec<Causes>,
    blocked: Mask,
}

impl Obstacles {
    /// Obstacles of a chart for a least depth \[m\] and a margin \[m\], for informative maneuvers, including
    /// areas that only these avoid. A greater least depth and a greater margin only add blocked cells.
    ///
    /// Obstacles up to the margin outside the raster are included. The least depth has no effect on charts of
    /// land only.
    ///
    /// # Errors
    /// A raster without cells or with too many (its margin included); a least depth or margin that is not
    /// finite; a negative margin.
    pub fn new(chart: &Chart, raster: Raster, least_depth_m: f64, margin_m: f64) -> Result<Self, Invalid> {
        Self::of(chart, raster, [least_depth_m, margin_m], Activity::Maneuvers)
    }

    /// The same for transit, which may cross areas that are kept free of maneuvers
    /// ([`crate::Class::TransitOnly`]).
    ///
    /// # Errors
    /// As [`Obstacles::new`].
    pub fn in_transit(
        chart: &Chart,
        raster: Raster,
        least_depth_m: f64,
        margin_m: f64,
    ) -> Result<Self, Invalid> {
        Self::of(chart, raster, [least_depth_m, margin_m], Activity::Transit)
    }

    fn of(chart: &Chart, raster: Raster, limits: [f64; 2], activity: Activity) -> Result<Self, Invalid> {
        raster.check()?;
        let cells = raster.nx * raster.ny;
        let (mut causes, mut blocked) = (Vec::with_capacity(cells), Vec::with_capacity(cells));
        let reach = (limits[1] / raster.cell_m).powi(2);
        let distances = Distances::of(chart, raster, limits, activity, &|| true, |cause, gap| {
            causes.push(cause);
            blocked.push(cause.any() || gap < reach);
        })?;
        let Some(distances) = distances else { unreachable!("there is no time limit") };
        Ok(Self { distances, causes, blocked: Mask::new(raster, blocked) })
    }

    /// The raster.
    pub fn raster(&self) -> Raster {
        self.distances.raster
    }

    /// Whether a cell is blocked, including the margin; cells off the raster are.
    pub fn is_blocked(&self, col: usize, row: usize) -> bool {
        self.distances.index(col, row).is_none_or(|k| self.blocked.closed()[k])
    }

    /// Why a cell is an obstacle, regardless of the margin; `NONE` for cells that are free or blocked by the
    /// margin only.
    pub fn causes(&self, col: usize, row: usize) -> Causes {
        self.distances.index(col, row).map_or(Causes::UNCHARTED, |k| self.causes[k])
    }

    /// Blocked cells, row by row from the south: `nx · ny` entries.
    pub fn blocked(&self) -> &[bool] {
        self.blocked.closed()
    }

    /// See [`Distances::distance_m`].
    pub fn distance_m(&self, x: f64, y: f64) -> f64 {
        self.distances.distance_m(x, y)
    }

    /// Whether a footprint at node (col, row) covers free cells only. Cells off the raster are blocked, and a
    /// footprint of another cell size never fits. Takes one look-up per run.
    pub fn is_free(&self, footprint: &Footprint, col: usize, row: usize) -> bool {
        self.blocked.is_free(footprint, col, row)
    }
}

/// Number of cells that the raster is widened by to include obstacles up to the margin outside.
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
