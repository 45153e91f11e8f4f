//! Cells of a raster that a chart's layers block.

use crate::chart::Charted;
use crate::grid::LAND;
use crate::plane::{Size, along, centres, each_edge};
use crate::{Bounds, Called, Chart, Class, Footprint, PlacedGrid, Polygon, Raster, Uncharted};

/// Cells that touch within this distance count as touched, so that rounding does not decide \[m\].
const TOUCH_M: f64 = 1e-6;

/// What the ship is doing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Activity {
    /// Moving between maneuvers.
    Transit,
    /// Informative maneuvers.
    Maneuvers,
}

/// Per cell of a raster, row by row from the south, why it is blocked.
pub(crate) struct Occupancy {
    raster: Raster,
    bounds: Bounds,
    size: Size,
    slack: f64,
    pub causes: Vec<Causes>,
}

impl Occupancy {
    pub(crate) fn of(chart: &Chart, raster: Raster, least_depth_m: f64, activity: Activity) -> Self {
        let mut occupancy = Self::open(raster);
        for polygon in chart.polygons() {
            if let Some(cause) = cause_of(polygon.class, least_depth_m, activity) {
                occupancy.block(polygon, cause);
            }
        }
        for grid in chart.grids() {
            occupancy.block_grid(grid, least_depth_m);
        }
        if chart.uncharted() == Uncharted::Obstacle {
            occupancy.block_uncharted(chart.charted());
        }
        occupancy.block_outside(&chart.area());
        occupancy
    }

    /// Blocks cells where nothing is charted, or a grid has no data, regardless of how uncharted places are treated.
    pub(crate) fn of_uncharted(chart: &Chart, raster: Raster) -> Self {
        let mut occupancy = Self::open(raster);
        chart.grids().iter().for_each(|grid| occupancy.block_grid(grid, f64::NEG_INFINITY));
        occupancy.causes.iter_mut().for_each(|cause| *cause = cause.only(Causes::UNCHARTED));
        if let Some(charted) = chart.covered() {
            occupancy.block_uncharted(&charted);
        }
        occupancy
    }

    /// Nothing is blocked.
    fn open(raster: Raster) -> Self {
        Self {
            raster,
            bounds: raster.bounds().grown(TOUCH_M),
            size: Size { nx: raster.nx, ny: raster.ny },
            slack: TOUCH_M / raster.cell_m,
            causes: vec![Causes::NONE; raster.nx * raster.ny],
        }
    }

    /// Blocks every cell that a polygon touches.
    fn block(&mut self, polygon: &Polygon, cause: Causes) {
        if !polygon.bounds.meets(&self.bounds) {
            return;
        }
        let rings = self.rings(polygon);
        let (nx, size, slack) = (self.raster.nx, self.size, self.slack);
        let mut mark = |row: usize, first: usize, last: usize| {
            self.causes[row * nx + first..=row * nx + last].iter_mut().for_each(|c| *c = c.with(cause));
        };
        each_edge(&rings, |a, b| along(a, b, slack, size, &mut mark));
        centres(&rings, size, mark);
    }

    fn rings(&self, polygon: &Polygon) -> Vec<Vec<[f64; 2]>> {
        let ring = |r: &Vec<[f64; 2]>| r.iter().map(|p| self.raster.in_cells(*p)).collect();
        polygon.rings.iter().map(ring).collect()
    }

    /// Blocks cells that touch unsafe cells of a grid, by runs of equal cause along its rows.
    fn block_grid(&mut self, grid: &PlacedGrid, least_depth_m: f64) {
        each_strip(grid, least_depth_m, |strip, cause| self.block(strip, cause));
    }

    /// Blocks every cell that is not entirely charted: by one polygon, or by several that share the borders inside it.
    fn block_uncharted(&mut self, charted: &Charted) {
        let nx = self.raster.nx;
        let (size, slack) = (self.size, self.slack);
        let mut whole = vec![false; self.causes.len()];
        let mut centre = vec![false; self.causes.len()];
        let mut border = vec![0_u32; self.causes.len()];
        for (id, polygon) in (1..).zip(charted.polygons.iter().filter(|p| p.bounds.meets(&self.bounds))) {
            let rings = self.rings(polygon);
            each_edge(&rings, |a, b| {
                along(a, b, slack, size, |row, first, last| {
                    border[row * nx + first..=row * nx + last].fill(id);
                });
            });
            centres(&rings, size, |row, first, last| {
                for k in row * nx + first..=row * nx + last {
                    centre[k] = true;
                    whole[k] |= border[k] != id;
                }
            });
        }
        for edge in &charted.frontier {
            let [a, b] = edge.map(|p| self.raster.in_cells(p));
            along(a, b, slack, size, |row, first, last| {
                centre[row * nx + first..=row * nx + last].fill(false)
            });
        }
        let known = whole.iter().zip(&centre).map(|(whole, centre)| *whole || *centre);
        for (cause, _) in self.causes.iter_mut().zip(known).filter(|(_, known)| !known) {
            *cause = cause.with(Causes::UNCHARTED);
        }
    }

    /// Blocks every cell that is not entirely inside the area.
    fn block_outside(&mut self, area: &Bounds) {
        let raster = self.raster;
        let area = area.grown(TOUCH_M);
        let inside = |index: usize, axis: usize| {
            let low = raster.origin[axis] + index as f64 * raster.cell_m;
            low >= area.min[axis] && low + raster.cell_m <= area.max[axis]
        };
        let columns: Vec<bool> = (0..raster.nx).map(|i| inside(i, 0)).collect();
        for (row, causes) in self.causes.chunks_mut(raster.nx).enumerate() {
            let row_inside = inside(row, 1);
            for (cause, _) in causes.iter_mut().zip(&columns).filter(|(_, c)| !(**c && row_inside)) {
                *cause = cause.with(Causes::UNCHARTED);
            }
        }
    }
}

impl Chart {
    /// Per cell of a raster, row by row from the south, whether any part of it is uncharted, regardless of
    /// how such places are treated.
    ///
    /// Charts with depths cover their depth and land polygons and depth grids, charts of land in polygons
    /// cover everything, and grids of land cover their extent; cells without data cover nothing.
    pub fn uncharted_cells(&self, raster: Raster) -> Vec<bool> {
        let causes = Occupancy::of_uncharted(self, raster).causes;
        causes.into_iter().map(Causes::any).collect()
    }
}

/// The unsafe cells of a grid, by runs of equal cause along its rows.
pub(crate) fn each_strip(grid: &PlacedGrid, least_depth_m: f64, mut each: impl FnMut(&Polygon, Causes)) {
    let [land, shoal, missing] = ["land", "shoal", "no data"].map(Called::plain);
    let bad = |value: f32| bad(value, grid.has_depth, least_depth_m);
    for row in 0..grid.rows {
        let mut start = 0;
        for run in grid.row(row).chunk_by(|a, b| bad(*a) == bad(*b)) {
            let columns = start..start + run.len();
            start = columns.end;
            let Some(cause) = bad(run[0]) else { continue };
            let called = match cause {
                Causes::UNCHARTED => &missing,
                Causes::LAND => &land,
                _ => &shoal,
            };
            // Where the projection fails within a grid, the whole grid is closed.
            let outline = grid.strip(columns, row..row + 1).or_else(|| grid.frame());
            let strip = outline.and_then(|ring| Polygon::of_rings(Class::Land, called, vec![ring]));
            strip.iter().for_each(|s| each(s, cause));
        }
    }
}

pub(crate) fn cause_of(class: Class, least_depth_m: f64, activity: Activity) -> Option<Causes> {
    match class {
        Class::TransitOnly => (activity == Activity::Maneuvers).then_some(Causes::NO_GO),
        Class::Land => Some(Causes::LAND),
        Class::NoGo => Some(Causes::NO_GO),
        Class::Depth { least_m: Some(depth) } | Class::Danger { least_m: Some(depth) }
            if depth >= least_depth_m =>
        {
            None
        }
        Class::Depth { .. } | Class::Danger { .. } => Some(Causes::SHOAL),
    }
}

/// Why a kept value is unsafe. Both depths are compared to its seven digits.
fn bad(value: f32, has_depth: bool, least_depth_m: f64) -> Option<Causes> {
    if value.is_nan() {
        Some(Causes::UNCHARTED)
    } else if has_depth {
        (value < least_depth_m as f32).then_some(Causes::SHOAL)
    } else {
        (value == LAND).then_some(Causes::LAND)
    }
}

/// Why a cell is blocked: any of four reasons.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Causes(u8);

impl Causes {
    /// Free.
    pub const NONE: Self = Self(0);
    /// Part of it is land.
    pub const LAND: Self = Self(1);
    /// Part of it is no-go.
    pub const NO_GO: Self = Self(2);
    /// Part of it is shoaler than the least depth, or of unknown depth.
    pub const SHOAL: Self = Self(4);
    /// Part of it is not charted, or outside the chart's area.
    pub const UNCHARTED: Self = Self(8);

    /// Whether there is any cause.
    pub fn any(self) -> bool {
        self.0 != 0
    }

    /// Whether `cause` is among them.
    pub fn has(self, cause: Self) -> bool {
        self.0 & cause.0 != 0
    }

    /// The cause, if no other is set.
    pub(crate) fn only(self, cause: Self) -> Self {
        Self(self.0 & cause.0)
    }

    /// A number of its own for every set of causes.
    pub(crate) fn bits(self) -> u8 {
        self.0
    }

    pub(crate) fn with(self, cause: Self) -> Self {
        Self(self.0 | cause.0)
    }
}

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
    pub fn within<'a>(polygons: impl IntoIterator<Item = &'a Polygon>, raster: Raster) -> Self {
        let mut closed = vec![false; raster.nx * raster.ny];
        for polygon in polygons {
            let (edge, inside) = cells(polygon, raster);
            let touched = edge.iter().zip(inside).map(|(edge, inside)| *edge || inside);
            closed.iter_mut().zip(touched).for_each(|(closed, touched)| *closed |= touched);
        }
        Self::new(raster, closed)
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
