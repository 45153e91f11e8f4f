//! The dangers along a track: the nearest one, and the least depth.

use crate::cover::each_edge;
use crate::occupancy::{Activity, cause_of, each_strip};
use crate::{Bounds, Called, Chart, Class, GridCell, PlacedGrid, Polygon};

/// Distance from an edge at which a point is beside it and not on it \[m\].
const OFFSET_M: f64 = 0.5;

/// Everything that a ship in transit keeps clear of.
pub struct Dangers<'a> {
    chart: &'a Chart,
    polygons: Vec<Polygon>,
}

/// The nearest danger.
#[derive(Clone, Debug, PartialEq)]
pub struct Nearest {
    /// Its name.
    pub called: Called,
    /// Its distance, less the uncertainty of its position \[m\].
    pub distance_m: f64,
}

impl Chart {
    /// Land, no-go areas, and water shoaler than `least_depth_m` \[m\].
    pub fn dangers(&self, least_depth_m: f64) -> Dangers<'_> {
        let is_danger = |p: &&Polygon| cause_of(p.class, least_depth_m, Activity::Transit).is_some();
        let mut polygons: Vec<Polygon> = self.polygons().iter().filter(is_danger).cloned().collect();
        for grid in self.grids() {
            each_strip(grid, least_depth_m, |strip, _| polygons.push(strip.clone()));
        }
        Dangers { chart: self, polygons }
    }

    /// The least depth \[m\] charted at any of `places` (east and north \[m\]); `None` where no depth is charted.
    pub fn least_depth_m(&self, places: &[[f64; 2]]) -> Option<f64> {
        let area = Bounds::enclosing(places)?;
        let own = |p: &Polygon| {
            let Class::Depth { least_m: Some(depth) } = p.class else { return None };
            let inside = p.bounds.meets(&area) && places.iter().any(|place| is_inside(p, *place));
            inside.then_some(depth)
        };
        let gridded = |grid: &PlacedGrid| {
            let cells = places.iter().filter_map(|place| grid.at(*place));
            let depths =
                cells.filter_map(|c| if let GridCell::Depth(depth) = c { Some(depth) } else { None });
            depths.reduce(f64::min)
        };
        let depths = self.polygons().iter().filter_map(own).chain(self.grids().iter().filter_map(gridded));
        depths.reduce(f64::min)
    }
}

impl Dangers<'_> {
    /// The danger nearest to any of `places` (east and north \[m\]); `None` where there is none, or no place.
    pub fn nearest(&self, places: &[[f64; 2]]) -> Option<Nearest> {
        let area = Bounds::enclosing(places)?;
        let mut best: Option<(f64, &Called)> = None;
        for polygon in &self.polygons {
            let farthest = best.map_or(f64::INFINITY, |(gap, _)| gap);
            if apart(&polygon.bounds, &area) >= farthest {
                continue;
            }
            let gap = gap_to(polygon, places, farthest);
            if gap < farthest {
                best = Some((gap, &polygon.called));
            }
        }
        let farthest = best.map_or(f64::INFINITY, |(gap, _)| gap);
        let edge = places.iter().fold(farthest, |least, place| least.min(self.edge_m(*place, least)));
        let nearest = best.map(|(distance_m, called)| Nearest { called: called.clone(), distance_m });
        if edge < farthest {
            return Some(Nearest { called: Called::plain("edge of the charted area"), distance_m: edge });
        }
        nearest
    }

    /// Distance to the edge of the charted area; any greater number where that is `farthest` or more \[m\].
    fn edge_m(&self, place: [f64; 2], farthest: f64) -> f64 {
        let charted = self.chart.charted();
        let mut least = farthest;
        for [a, b] in &charted.frontier {
            let (gap, at) = nearest_on(place, *a, *b);
            if gap >= least {
                continue;
            }
            // A polygon may end within another one.
            let length = libm::hypot(b[0] - a[0], b[1] - a[1]).max(f64::MIN_POSITIVE);
            let aside = [(b[1] - a[1]) / length, (a[0] - b[0]) / length];
            let is_charted = |side: f64| {
                let beyond = [0, 1].map(|k| at[k] + side * OFFSET_M * aside[k]);
                charted.polygons.iter().any(|polygon| is_inside(polygon, beyond))
            };
            if !(is_charted(-1.0) && is_charted(1.0)) {
                least = gap;
            }
        }
        least
    }
}

impl PlacedGrid {
    /// The cell that holds a place; its edges are taken as straight.
    pub fn at(&self, place: [f64; 2]) -> Option<GridCell> {
        let corner = |column: usize, row: usize| self.corner(column, row);
        let origin = corner(0, 0)?;
        let along = |end: [f64; 2], count: usize| [0, 1].map(|k| (end[k] - origin[k]) / count as f64);
        let (a, b) = (along(corner(self.columns, 0)?, self.columns), along(corner(0, self.rows)?, self.rows));
        let p = [place[0] - origin[0], place[1] - origin[1]];
        let det = a[0] * b[1] - a[1] * b[0];
        let column = ((p[0] * b[1] - p[1] * b[0]) / det).floor();
        let row = ((a[0] * p[1] - a[1] * p[0]) / det).floor();
        let inside = column >= 0.0 && row >= 0.0 && column < self.columns as f64 && row < self.rows as f64;
        inside.then(|| self.cell(column as usize, row as usize))
    }
}

/// Distance between two boxes.
fn apart(a: &Bounds, b: &Bounds) -> f64 {
    let gap = |k: usize| (a.min[k] - b.max[k]).max(b.min[k] - a.max[k]).max(0.0);
    libm::hypot(gap(0), gap(1))
}

/// Distance to the nearest of `places`; 0 inside; may be any greater number where it is `farthest` or more.
fn gap_to(polygon: &Polygon, places: &[[f64; 2]], farthest: f64) -> f64 {
    let near = places.iter().filter(|p| apart(&polygon.bounds, &Bounds { min: **p, max: **p }) < farthest);
    let gap = |place: &[f64; 2]| {
        if is_inside(polygon, *place) {
            return 0.0;
        }
        let mut least = f64::INFINITY;
        each_edge(&polygon.rings, |a, b| least = least.min(from_segment(*place, a, b)));
        least
    };
    near.map(gap).fold(f64::INFINITY, f64::min)
}

/// By the even-odd rule.
fn is_inside(polygon: &Polygon, [x, y]: [f64; 2]) -> bool {
    let Bounds { min, max } = polygon.bounds;
    if x < min[0] || x > max[0] || y < min[1] || y > max[1] {
        return false;
    }
    let mut inside = false;
    each_edge(&polygon.rings, |a, b| {
        let crosses = (a[1] > y) != (b[1] > y) && x < a[0] + (y - a[1]) / (b[1] - a[1]) * (b[0] - a[0]);
        inside ^= crosses;
    });
    inside
}

fn from_segment(place: [f64; 2], a: [f64; 2], b: [f64; 2]) -> f64 {
    nearest_on(place, a, b).0
}

/// Distance to a segment, and its nearest point.
fn nearest_on(place: [f64; 2], a: [f64; 2], b: [f64; 2]) -> (f64, [f64; 2]) {
    let (ab, ap) = ([b[0] - a[0], b[1] - a[1]], [place[0] - a[0], place[1] - a[1]]);
    let squared = ab[0] * ab[0] + ab[1] * ab[1];
    let t = if squared > 0.0 { ((ap[0] * ab[0] + ap[1] * ab[1]) / squared).clamp(0.0, 1.0) } else { 0.0 };
    (libm::hypot(ap[0] - t * ab[0], ap[1] - t * ab[1]), [a[0] + t * ab[0], a[1] + t * ab[1]])
}
