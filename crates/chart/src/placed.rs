//! Polygons of longitude and latitude on the plane.

use std::ops::Range;
use std::sync::Arc;

use crate::grid::{Block, Header, MOST_KEPT, window};
use crate::ring::doubled_area;
use crate::{Area, Bounds, Called, Class, Contour, Crs, Grid, GridCell, Invalid, Mark, Plane};

/// Longest segment of an edge \[deg of latitude\]: about a kilometre, over which the straight line in
/// longitude and latitude and the one on the plane differ by less than 0.1 m up to 70° of latitude.
const SEGMENT_DEG: f64 = 0.01;
/// Corners of half a circle around the end of a line.
const HALF_CIRCLE: usize = 8;

/// A charted point on the plane: a danger, or a sounding.
#[derive(Clone, Debug, PartialEq)]
pub struct Spot {
    /// What it is.
    pub class: Class,
    /// Its name.
    pub called: Called,
    /// Whether it is a sounding, and not an object.
    pub sounding: bool,
    /// East and north \[m\].
    pub place: [f64; 2],
}

impl Spot {
    /// `None` for a line.
    pub(crate) fn place(mark: &Mark, plane: &Plane) -> Option<Self> {
        let [[longitude, latitude]] = mark.positions[..] else { return None };
        let place = plane.to_plane(longitude, latitude);
        Some(Self { class: mark.class, called: mark.called.clone(), sounding: mark.sounding, place })
    }
}

impl Contour {
    /// On the plane; `None` if it does not meet `area`.
    pub(crate) fn place(charted: &Self, plane: &Plane, area: &Bounds) -> Option<Self> {
        let line = place_line(&charted.line, plane);
        let bounds = Bounds::enclosing(&line)?;
        bounds.meets(area).then_some(Self { depth_m: charted.depth_m, line })
    }
}

/// A polygon on the plane.
#[derive(Clone, Debug, PartialEq)]
pub struct Polygon {
    /// What it is.
    pub class: Class,
    /// Its name.
    pub called: Called,
    /// Whether it is the area around a charted point.
    pub is_of_point: bool,
    /// Rings \[m\] without the repeated last position: the outer one counter-clockwise, then the holes
    /// clockwise. Edges are divided to about a kilometre, so that they follow the straight lines of the file.
    pub rings: Vec<Vec<[f64; 2]>>,
    /// Its bounding box.
    pub bounds: Bounds,
}

impl Polygon {
    /// `None` for a polygon without a finite point.
    pub(crate) fn place(area: &Area, plane: &Plane) -> Option<Self> {
        let ring = |(k, r): (usize, &Vec<[f64; 2]>)| oriented(place_ring(r, plane), k == 0);
        Self::of_rings(area.class, &area.called, area.rings.iter().enumerate().map(ring).collect())
    }

    /// The polygon of corners (longitude, latitude \[deg\]) in their order; `None` without a finite one.
    pub fn of_corners(class: Class, corners: &[[f64; 2]], plane: &Plane) -> Option<Self> {
        let closed: Vec<[f64; 2]> = corners.iter().chain(corners.first()).copied().collect();
        Self::of_rings(class, &Called::plain("area"), vec![oriented(place_ring(&closed, plane), true)])
    }

    /// Distance from a place inside to the nearest edge; below 0 outside \[m\].
    pub fn inside_m(&self, [x, y]: [f64; 2]) -> f64 {
        let (mut inside, mut nearest) = (false, f64::INFINITY);
        for [a, b] in self.edges() {
            let [along, up] = [b[0] - a[0], b[1] - a[1]];
            inside ^= (a[1] > y) != (b[1] > y) && x < a[0] + (y - a[1]) / up * along;
            let part = ((x - a[0]) * along + (y - a[1]) * up) / (along * along + up * up);
            let part = if part.is_finite() { part.clamp(0.0, 1.0) } else { 0.0 };
            nearest = nearest.min(libm::hypot(x - a[0] - part * along, y - a[1] - part * up));
        }
        if inside { nearest } else { -nearest }
    }

    /// The area within the radius of a point or line: one polygon for the point, or for each straight segment of the line.
    pub(crate) fn buffer(mark: &Mark, plane: &Plane) -> Vec<Self> {
        let line = place_line(&mark.positions, plane);
        let segments = line.windows(line.len().clamp(1, 2));
        let ring = |segment: &[[f64; 2]]| capsule(segment[0], segment[segment.len() - 1], mark.radius_m);
        let polygons =
            segments.filter_map(|segment| Self::of_rings(mark.class, &mark.called, vec![ring(segment)]));
        polygons.map(|polygon| Self { is_of_point: mark.positions.len() == 1, ..polygon }).collect()
    }

    pub(crate) fn of_rings(class: Class, called: &Called, rings: Vec<Vec<[f64; 2]>>) -> Option<Self> {
        let bounds = Bounds::enclosing(rings.iter().flatten())?;
        let finite = rings.iter().flatten().flatten().all(|v| v.is_finite());
        finite.then(|| Self { class, called: called.clone(), is_of_point: false, rings, bounds })
    }

    /// Edges in the direction that keeps the polygon on the left.
    pub(crate) fn edges(&self) -> impl Iterator<Item = [[f64; 2]; 2]> + '_ {
        self.rings.iter().flat_map(|r| (0..r.len()).map(|i| [r[i], r[(i + 1) % r.len()]]))
    }
}

pub(crate) fn oriented(mut ring: Vec<[f64; 2]>, counter_clockwise: bool) -> Vec<[f64; 2]> {
    let closing = ring.first().copied();
    ring.extend(closing);
    let is = doubled_area(&ring) > 0.0;
    ring.pop();
    if is != counter_clockwise {
        ring.reverse();
    }
    ring
}

/// A counter-clockwise ring around everything within `radius_m` of the straight line between two points: its
/// corners are a little farther away, so that its edges do not cut into the half circles.
fn capsule(a: [f64; 2], b: [f64; 2], radius_m: f64) -> Vec<[f64; 2]> {
    let step = std::f64::consts::PI / HALF_CIRCLE as f64;
    let reach = radius_m / libm::cos(step / 2.0);
    let ahead = libm::atan2(b[1] - a[1], b[0] - a[0]);
    let corner =
        |end: [f64; 2], angle: f64| [end[0] + reach * libm::cos(angle), end[1] + reach * libm::sin(angle)];
    // From abeam to abeam around each end, the half steps outside of the line's own width.
    let half = |end: [f64; 2], from: f64| {
        (0..=HALF_CIRCLE).map(move |k| corner(end, from + (k as f64 - 0.5) * step)).collect::<Vec<_>>()
    };
    let quarter = std::f64::consts::FRAC_PI_2;
    [half(b, ahead - quarter), half(a, ahead + quarter)].concat()
}

/// With both ends.
fn place_line(positions: &[[f64; 2]], plane: &Plane) -> Vec<[f64; 2]> {
    let mut line = place_ring(positions, plane);
    line.extend(positions.last().map(|p| plane.to_plane(p[0], p[1])));
    line
}

fn place_ring(ring: &[[f64; 2]], plane: &Plane) -> Vec<[f64; 2]> {
    let mut placed = Vec::with_capacity(ring.len());
    for w in ring.windows(2) {
        placed.push(plane.to_plane(w[0][0], w[0][1]));
        placed.extend(between(w[0], w[1]).into_iter().map(|p| plane.to_plane(p[0], p[1])));
    }
    placed
}

/// Points that divide a long edge, which goes the short way round the earth. They do not depend on the
/// direction of the edge, so that neighbours keep a common border.
fn between(a: [f64; 2], b: [f64; 2]) -> Vec<[f64; 2]> {
    let forward = a <= b;
    let (p, q) = if forward { (a, b) } else { (b, a) };
    let turn = 360.0 * ((q[0] - p[0]) / 360.0).round();
    let q = [q[0] - turn, q[1]];
    let east = (q[0] - p[0]) * libm::cos(f64::to_radians((p[1] + q[1]) / 2.0));
    let segments = (libm::hypot(east, q[1] - p[1]) / SEGMENT_DEG).ceil().max(1.0) as usize;
    let at = |i: usize| {
        let t = i as f64 / segments as f64;
        [p[0] + t * (q[0] - p[0]), p[1] + t * (q[1] - p[1])]
    };
    let points = (1..segments).map(at);
    if forward { points.collect() } else { points.rev().collect() }
}

/// Corners on a side of a block of cells whose corners are not kept: a side between two of them is nearly straight.
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
        let place = [0, 1].map(|k: usize| self.corner[k] + index[k] as f64 * self.cell);
        let (lon, lat) = self.crs.to_geographic(place)?;
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
            let size = format!("{} cells of {} × {}", grid.cells.len(), grid.columns, grid.rows);
            return Err(Invalid::new(
                "grid",
                size,
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
