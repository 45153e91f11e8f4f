use crate::occupancy::{Activity, Occupancy};
use crate::plane::MOST_CELLS;
use crate::{Causes, Chart, Footprint, Invalid, Mask, Raster};

/// The distance of every cell of a raster to the nearest charted obstacle: the part of [`Obstacles`] that a clearance needs.
#[derive(Clone, Debug)]
pub struct Distances {
    raster: Raster,
    gap_m: Vec<f32>,
}

impl Distances {
    /// Approximate bytes per cell, including those around the raster, while distances are computed.
    pub const FOUND_BYTES: u64 = 9;

    /// [`Obstacles::new`] for a least depth \[m\], with distances up to `sight_m`; `None` once `keep_going` returns false.
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
                let row_causes = &causes[wide_row * wide.nx + pad..][..raster.nx];
                for (col, (cause, gap)) in row_causes.iter().zip(&squared[pad..]).enumerate() {
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
            [(col, nx), (row, ny)].map(|(index, count)| (index - 0.5).clamp(0.0, count as f64 - 1.0));
        let [west, south] = [col, row].map(|index| index as usize);
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
/// A cell is an *obstacle* when any part of it is land, no-go, shoaler than the least depth, or not charted. It is *blocked*
/// when the least distance between any of its points and any point of an obstacle cell is below the margin. So a free cell
/// keeps all its points at least the margin away from everything charted; because whole cells are compared, the kept
/// distance may be larger by up to one diagonal of the obstacle's cell and one of its own (70 m in all at 25 m).
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
    /// Obstacles up to the margin outside the raster are included. The least depth has no effect on charts of land only.
    ///
    /// # Errors
    /// A raster without cells or with too many (its margin included); a least depth or margin that is not
    /// finite; a negative margin.
    pub fn new(chart: &Chart, raster: Raster, least_depth_m: f64, margin_m: f64) -> Result<Self, Invalid> {
        Self::of(chart, raster, [least_depth_m, margin_m], Activity::Maneuvers)
    }

    /// The same for transit, which may cross areas that are kept free of maneuvers ([`crate::Class::TransitOnly`]).
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

    /// Why a cell is an obstacle, regardless of the margin; `NONE` for cells that are free or blocked by the margin only.
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

// Exact Euclidean distance transform (Felzenszwalb and Huttenlocher 2012), of gaps between cells.

/// Squared gap, in units of cells, from every cell to the nearest set cell: the least distance of any of
/// their points, max(|Δcol| − 1, 0)² + max(|Δrow| − 1, 0)². Infinite where no cell is set. `each` is called
/// with every row of `nx` columns in turn. `None` once `keep_going`, which is checked at every row, returns false.
///
/// The gap between squares is the distance between centres after the set cells have grown by their eight
/// neighbours, so the transform of centres stays exact.
fn squared_gaps(
    set: impl Fn(usize) -> bool,
    [nx, ny]: [usize; 2],
    keep_going: &dyn Fn() -> bool,
    mut each: impl FnMut(usize, &[f64]),
) -> Option<()> {
    let vertical = vertical_gaps(set, [nx, ny], keep_going)?;
    let mut parts = Vec::with_capacity(nx);
    let (mut grown, mut squared) = (vec![0.0; nx], vec![0.0; nx]);
    for (row, rows) in vertical.chunks(nx.max(1)).enumerate() {
        for (i, g) in grown.iter_mut().enumerate() {
            let near = i.saturating_sub(1)..(i + 2).min(nx);
            *g = between(rows[near].iter().copied().min().unwrap_or(NONE));
        }
        envelope(&grown, &mut parts);
        fill(&parts, &mut squared);
        each(row, &squared);
        keep_going().then_some(())?;
    }
    Some(())
}

/// No set cell in a column.
const NONE: u32 = u32::MAX;

/// Squared gap of cells whose rows differ by `rows`.
fn between(rows: u32) -> f64 {
    if rows == NONE { f64::INFINITY } else { f64::from(rows.saturating_sub(1)).powi(2) }
}

/// Rows to the nearest set cell of the same column.
fn vertical_gaps(
    set: impl Fn(usize) -> bool,
    [nx, ny]: [usize; 2],
    keep_going: &dyn Fn() -> bool,
) -> Option<Vec<u32>> {
    let mut rows = vec![NONE; nx * ny];
    let mut since = vec![NONE; nx];
    let mut sweep = |row: usize| {
        for (i, s) in since.iter_mut().enumerate() {
            let k = row * nx + i;
            *s = if set(k) { 0 } else { s.saturating_add(1) };
            rows[k] = rows[k].min(*s);
        }
        keep_going().then_some(())
    };
    (0..ny).try_for_each(&mut sweep)?;
    // After the first sweep a distance in the last row counts from below: it is too long for any row above, so harmless.
    (0..ny).rev().try_for_each(sweep)?;
    Some(rows)
}

/// Puts the lower envelope of the parabolas (x − i)² + f(i) into `parts`: where each begins, its vertex and height.
fn envelope(f: &[f64], parts: &mut Vec<(f64, f64, f64)>) {
    parts.clear();
    for (i, height) in f.iter().copied().enumerate().filter(|(_, h)| h.is_finite()) {
        let vertex = i as f64;
        let meets =
            |&(_, v, h): &(f64, f64, f64)| ((height + vertex * vertex) - (h + v * v)) / (2.0 * (vertex - v));
        while parts.last().is_some_and(|part| meets(part) <= part.0) {
            parts.pop();
        }
        let begin = parts.last().map_or(f64::NEG_INFINITY, meets);
        parts.push((begin, vertex, height));
    }
}

/// The values of an envelope at 0, 1, 2 and so on.
fn fill(parts: &[(f64, f64, f64)], row: &mut [f64]) {
    let mut k = 0;
    for (i, value) in row.iter_mut().enumerate() {
        let x = i as f64;
        while parts.get(k + 1).is_some_and(|next| next.0 <= x) {
            k += 1;
        }
        *value = parts.get(k).map_or(f64::INFINITY, |(_, v, h)| (x - v).powi(2) + h);
    }
}
