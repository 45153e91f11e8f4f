//! The local plane, boxes and rasters on it, and the cells that segments and polygons cover.

use geographiclib_rs::{DirectGeodesic, Geodesic, InverseGeodesic};

use crate::Invalid;

/// A local plane about an origin, x east and y north \[m\]: the azimuthal equidistant projection of WGS84.
///
/// Distances and directions from the origin are those of the geodesic. Across the radius, at a distance r of the origin,
/// lengths are too long by r²/(6 R²): 4·10⁻⁷ at 10 km, 1·10⁻⁵ at 50 km, 4·10⁻⁵ at 100 km. Distances between any two points
/// within r are wrong by no more than that share. North on the plane is true north at the origin only: elsewhere it differs
/// by the convergence [`Plane::north_rad`], about x tan(latitude)/R (0.16° at x = 10 km, 60° north).
#[derive(Clone, Copy, Debug)]
pub struct Plane {
    lon_deg: f64,
    lat_deg: f64,
    earth: Geodesic,
}

impl Plane {
    /// The plane about `lon_deg`, `lat_deg` (WGS84).
    ///
    /// # Errors
    /// An origin that is not finite or outside ±180° and ±90°.
    pub fn new(lon_deg: f64, lat_deg: f64) -> Result<Self, Invalid> {
        if lon_deg.abs() <= 180.0 && lat_deg.abs() <= 90.0 {
            return Ok(Self { lon_deg, lat_deg, earth: Geodesic::wgs84() });
        }
        Err(Invalid::new(
            "origin of the plane",
            format!("longitude {lon_deg}, latitude {lat_deg}"),
            "degrees within ±180 and ±90, longitude first",
            "correct the origin",
        ))
    }

    /// The place of a longitude and latitude \[deg\] on the plane \[m\]; NaN for a latitude beyond ±90°.
    pub fn to_plane(&self, lon_deg: f64, lat_deg: f64) -> [f64; 2] {
        let (distance, azimuth, _, _) = self.earth.inverse(self.lat_deg, self.lon_deg, lat_deg, lon_deg);
        let (sin, cos) = libm::sincos(f64::to_radians(azimuth));
        [distance * sin, distance * cos]
    }

    /// Direction of true north at a place on the plane \[m\], clockwise from the plane's own north \[rad\]:
    /// subtract it from a heading on the plane to get the true heading.
    pub fn north_rad(&self, place: [f64; 2]) -> f64 {
        // Half a minute of latitude to either side: the chord has the direction of the meridian halfway. At a
        // pole the other side is missing.
        const STEP_DEG: f64 = 0.5 / 60.0;
        let (lon, lat) = self.to_geographic(place);
        let [south, north] =
            [lat - STEP_DEG, lat + STEP_DEG].map(|lat| self.to_plane(lon, lat.clamp(-90.0, 90.0)));
        libm::atan2(north[0] - south[0], north[1] - south[1])
    }

    /// Distance on the plane of two places of longitude and latitude \[m\].
    pub fn distance_m(&self, a: [f64; 2], b: [f64; 2]) -> f64 {
        let (a, b) = (self.to_plane(a[0], a[1]), self.to_plane(b[0], b[1]));
        libm::hypot(a[0] - b[0], a[1] - b[1])
    }

    /// Longitude (within ±180) and latitude \[deg\] of a place on the plane \[m\].
    pub fn to_geographic(&self, [x, y]: [f64; 2]) -> (f64, f64) {
        let azimuth = libm::atan2(x, y).to_degrees();
        let (lat, lon): (f64, f64) =
            self.earth.direct(self.lat_deg, self.lon_deg, azimuth, libm::hypot(x, y));
        // To a micrometre: the geodesic uses the system's sines, whose last bits differ between processors.
        let rounded = |degrees: f64| (degrees * 1e11).round() / 1e11;
        (rounded(lon), rounded(lat))
    }
}

/// Length of the geodesic between two places given as (longitude, latitude) \[deg\], in metres.
pub(crate) fn distance_m(a: (f64, f64), b: (f64, f64)) -> f64 {
    Geodesic::wgs84().inverse(a.1, a.0, b.1, b.0)
}

/// An axis-aligned box in the plane, x east and y north \[m\].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// The south-western corner.
    pub min: [f64; 2],
    /// The north-eastern corner.
    pub max: [f64; 2],
}

impl Bounds {
    /// The box between two corners.
    ///
    /// # Errors
    /// A corner that is not finite, or a box without area.
    pub fn new(min: [f64; 2], max: [f64; 2]) -> Result<Self, Invalid> {
        let finite = min.iter().chain(&max).all(|v| v.is_finite());
        if finite && min[0] < max[0] && min[1] < max[1] {
            return Ok(Self { min, max });
        }
        Err(Invalid::new(
            "box",
            format!("corners {min:?} and {max:?}"),
            "finite corners, the first south-west of the second",
            "correct the corners",
        ))
    }

    /// The box with its sides moved outwards by `by_m`.
    pub fn grown(&self, by_m: f64) -> Self {
        Self { min: self.min.map(|v| v - by_m), max: self.max.map(|v| v + by_m) }
    }

    /// Whether the boxes have a point in common.
    pub fn meets(&self, other: &Self) -> bool {
        (0..2).all(|k| self.min[k] <= other.max[k] && other.min[k] <= self.max[k])
    }

    /// Whether the point is inside or on the edge.
    pub fn contains(&self, point: [f64; 2]) -> bool {
        (0..2).all(|k| self.min[k] <= point[k] && point[k] <= self.max[k])
    }

    /// The smallest box that contains points; `None` without points.
    pub fn enclosing<'a>(points: impl IntoIterator<Item = &'a [f64; 2]>) -> Option<Self> {
        let grow = |b: Option<Self>, p: &[f64; 2]| match b {
            None => Some(Self { min: *p, max: *p }),
            Some(b) => Some(Self {
                min: [b.min[0].min(p[0]), b.min[1].min(p[1])],
                max: [b.max[0].max(p[0]), b.max[1].max(p[1])],
            }),
        };
        points.into_iter().fold(None, grow)
    }

    /// Points on the edge, `per_side` to a side, counter-clockwise from the south-western corner.
    pub(crate) fn edge(&self, per_side: usize) -> Vec<[f64; 2]> {
        let Self { min: [x0, y0], max: [x1, y1] } = *self;
        let corners = [[x0, y0], [x1, y0], [x1, y1], [x0, y1], [x0, y0]];
        let at = |k: usize, i: usize| {
            let t = i as f64 / per_side as f64;
            [0, 1].map(|d: usize| corners[k][d] + t * (corners[k + 1][d] - corners[k][d]))
        };
        (0..4).flat_map(|k| (0..per_side).map(move |i| at(k, i))).collect()
    }
}

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

// Which cells segments and polygons cover. Coordinates are in units of cells; a span is (row, first, last column).

/// Number of columns and rows.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Size {
    pub nx: usize,
    pub ny: usize,
}

impl Size {
    /// The whole numbers from floor(low) to floor(high) among 0..count.
    fn clamp(low: f64, high: f64, count: usize) -> Option<(usize, usize)> {
        if high < 0.0 || low >= count as f64 {
            return None;
        }
        // The conversion to an integer rounds down.
        let (first, last) = (low.max(0.0) as usize, (high as usize).min(count - 1));
        (first <= last).then_some((first, last))
    }
}

/// All cells within `slack` of a segment: those that it passes or touches, and no cell farther than `slack` from it.
pub(crate) fn along(
    a: [f64; 2],
    b: [f64; 2],
    slack: f64,
    size: Size,
    mut span: impl FnMut(usize, usize, usize),
) {
    let (low, high) = (a[1].min(b[1]) - slack, a[1].max(b[1]) + slack);
    let Some((first_row, last_row)) = Size::clamp(low, high, size.ny) else { return };
    for row in first_row..=last_row {
        let [x0, x1] = columns(a, b, row as f64 - slack, row as f64 + 1.0 + slack);
        if let Some((first, last)) = Size::clamp(x0 - slack, x1 + slack, size.nx) {
            span(row, first, last);
        }
    }
}

/// Range of x of a segment between two heights, one of which it reaches.
fn columns(a: [f64; 2], b: [f64; 2], low: f64, high: f64) -> [f64; 2] {
    let at = |y: f64| {
        let t = (y - a[1]) / (b[1] - a[1]);
        a[0] + t.clamp(0.0, 1.0) * (b[0] - a[0])
    };
    let level = (b[1] - a[1]).abs() < 1e-12;
    let (x0, x1) = if level { (a[0], b[0]) } else { (at(low), at(high)) };
    [x0.min(x1), x0.max(x1)]
}

/// The edges of rings that are not closed.
pub(crate) fn each_edge(rings: &[Vec<[f64; 2]>], mut edge: impl FnMut([f64; 2], [f64; 2])) {
    for ring in rings {
        let mut p = ring.last().copied().unwrap_or_default();
        for q in ring {
            edge(p, *q);
            p = *q;
        }
    }
}

/// All cells whose centre is inside the rings (not closed) by the even-odd rule.
pub(crate) fn centres(rings: &[Vec<[f64; 2]>], size: Size, mut span: impl FnMut(usize, usize, usize)) {
    let mut crossings: Vec<(usize, f64)> = Vec::new();
    each_edge(rings, |p, q| cross_rows(p, q, size, &mut crossings));
    crossings.sort_unstable_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)));
    // Every row is crossed an even number of times, so pairs never span rows.
    for pair in crossings.as_chunks::<2>().0 {
        let [(row, x0), (_, x1)] = *pair;
        if let Some((first, last)) = Size::clamp((x0 - 0.5).ceil(), (x1 - 0.5).ceil() - 1.0, size.nx) {
            span(row, first, last);
        }
    }
}

/// Where an edge crosses the centre lines of rows; the upper end of an edge does not belong to it.
fn cross_rows(p: [f64; 2], q: [f64; 2], size: Size, crossings: &mut Vec<(usize, f64)>) {
    let (low, high) = if p[1] <= q[1] { (p, q) } else { (q, p) };
    let first = (low[1] - 0.5).ceil();
    let last = (high[1] - 0.5).ceil() - 1.0;
    let Some((first, last)) = Size::clamp(first, last, size.ny) else { return };
    for row in first..=last {
        let t = (row as f64 + 0.5 - low[1]) / (high[1] - low[1]);
        crossings.push((row, low[0] + t * (high[0] - low[0])));
    }
}
