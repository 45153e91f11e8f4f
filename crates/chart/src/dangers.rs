//! The dangers along a track: the nearest one, and the least depth.

use std::collections::{BTreeMap, BTreeSet};

use crate::classes::{Judged, judged};
use crate::enc::class;
use crate::occupancy::{Activity, cause_of, each_strip};
use crate::plane::each_edge;
use crate::{Bounds, Called, Causes, Chart, Class, GridCell, PlacedGrid, Polygon, Uncharted};

/// Distance from an edge at which a point is beside it and not on it \[m\].
const OFFSET_M: f64 = 0.5;

/// Everything that a ship in transit keeps clear of.
pub struct Dangers<'a> {
    pub(crate) chart: &'a Chart,
    /// Each with what it is closed for.
    pub(crate) polygons: Vec<(Polygon, Causes)>,
}

/// The nearest danger.
#[derive(Clone, Debug, PartialEq)]
pub struct Nearest {
    /// Its name.
    pub called: Called,
    /// Its distance, less the uncertainty of its position \[m\].
    pub distance_m: f64,
    /// The place that it is nearest to, and its point there, east and north \[m\].
    pub between: [[f64; 2]; 2],
}

/// A distance \[m\], from a place to a point.
#[derive(Clone, Copy)]
pub(crate) struct Gap {
    pub(crate) distance_m: f64,
    between: [[f64; 2]; 2],
}

impl Gap {
    /// Farther than anything.
    pub(crate) const NONE: Self = Self { distance_m: f64::INFINITY, between: [[0.0; 2]; 2] };

    fn shorter(self, other: Self) -> Self {
        if other.distance_m < self.distance_m { other } else { self }
    }
}

impl Chart {
    /// Land, no-go areas, and water shoaler than `least_depth_m` \[m\].
    pub fn dangers(&self, least_depth_m: f64) -> Dangers<'_> {
        let closed = |p: &Polygon| Some((p.clone(), cause_of(p.class, least_depth_m, Activity::Transit)?));
        let mut polygons: Vec<(Polygon, Causes)> = self.polygons().iter().filter_map(closed).collect();
        for grid in self.grids() {
            each_strip(grid, least_depth_m, |strip, cause| polygons.push((strip.clone(), cause)));
        }
        Dangers { chart: self, polygons }
    }

    /// Classes and names, sorted, of the objects near any of `places` (east and north \[m\]) that the crew has to know about.
    pub fn noted_near(&self, places: &[[f64; 2]], within_m: f64) -> BTreeSet<String> {
        let near = self
            .noted()
            .iter()
            .filter(|(_, polygon)| gap_to(polygon, places, within_m).distance_m < within_m);
        near.map(|(_, polygon)| polygon.called.to_string()).collect()
    }

    /// The least depth \[m\] charted at any of `places` (east and north \[m\]); `None` where no depth is charted.
    pub fn least_depth_m(&self, places: &[[f64; 2]]) -> Option<f64> {
        let area = Bounds::enclosing(places)?;
        let polygon_depth = |p: &Polygon| {
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
        let depths =
            self.polygons().iter().filter_map(polygon_depth).chain(self.grids().iter().filter_map(gridded));
        depths.reduce(f64::min)
    }
}

impl Dangers<'_> {
    /// The danger nearest to any of `places` (east and north \[m\]); `None` where there is none, or no place.
    pub fn nearest(&self, places: &[[f64; 2]]) -> Option<Nearest> {
        let area = Bounds::enclosing(places)?;
        let mut best = (Gap::NONE, None);
        for (polygon, _) in &self.polygons {
            let farthest = best.0.distance_m;
            if apart(&polygon.bounds, &area) >= farthest {
                continue;
            }
            let gap = gap_to(polygon, places, farthest);
            if gap.distance_m < farthest {
                best = (gap, Some(&polygon.called));
            }
        }
        let edge = places.iter().fold(best.0, |least, place| self.edge(*place, least));
        let called = match best.1 {
            _ if edge.distance_m < best.0.distance_m => Called::plain("edge of the charted area"),
            Some(called) => called.clone(),
            None => return None,
        };
        Some(Nearest { called, distance_m: edge.distance_m, between: edge.between })
    }

    /// The first of `places` (east and north \[m\]) that is inside a danger, and the danger's name; `None` where none is.
    pub fn first_inside(&self, places: &[[f64; 2]]) -> Option<(usize, &Called)> {
        let holding = |place: &[f64; 2]| self.polygons.iter().find(|(polygon, _)| is_inside(polygon, *place));
        places.iter().enumerate().find_map(|(index, place)| Some((index, &holding(place)?.0.called)))
    }

    /// The gap to the edge of the charted area, or `least` if that is not longer.
    pub(crate) fn edge(&self, place: [f64; 2], mut least: Gap) -> Gap {
        let charted = self.chart.charted();
        for [a, b] in &charted.frontier {
            let (gap, at) = nearest_on(place, *a, *b);
            if gap >= least.distance_m {
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
                least = Gap { distance_m: gap, between: [place, at] };
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

/// The gap to the nearest of `places`; 0 inside; may be any longer one where it is `farthest` or more.
fn gap_to(polygon: &Polygon, places: &[[f64; 2]], farthest: f64) -> Gap {
    let near = places.iter().filter(|p| apart(&polygon.bounds, &Bounds { min: **p, max: **p }) < farthest);
    let gap = |place: &[f64; 2]| {
        if is_inside(polygon, *place) {
            return Gap { distance_m: 0.0, between: [*place; 2] };
        }
        let mut least = Gap::NONE;
        each_edge(&polygon.rings, |a, b| {
            let (distance_m, at) = nearest_on(*place, a, b);
            least = least.shorter(Gap { distance_m, between: [*place, at] });
        });
        least
    };
    near.map(gap).fold(Gap::NONE, Gap::shorter)
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

/// Distance to a segment, and its nearest point.
fn nearest_on(place: [f64; 2], a: [f64; 2], b: [f64; 2]) -> (f64, [f64; 2]) {
    let (ab, ap) = ([b[0] - a[0], b[1] - a[1]], [place[0] - a[0], place[1] - a[1]]);
    let squared = ab[0] * ab[0] + ab[1] * ab[1];
    let t = if squared > 0.0 { ((ap[0] * ab[0] + ap[1] * ab[1]) / squared).clamp(0.0, 1.0) } else { 0.0 };
    (libm::hypot(ap[0] - t * ab[0], ap[1] - t * ab[1]), [a[0] + t * ab[0], a[1] + t * ab[1]])
}

/// Dangers of one class and name that close places.
#[derive(Clone, Debug, PartialEq)]
pub struct Closing {
    /// Their class and name, and the greatest of their depths.
    pub called: Called,
    /// What they are closed for: land, no-go, too shoal, uncharted.
    pub cause: Causes,
    /// How many of the places they close.
    pub places: usize,
}

impl Closing {
    /// Their class, where `rules` of `plan.toml` may open it.
    pub fn rule(&self) -> Option<&'static str> {
        let of = |code: &u16| !matches!(judged(*code), Judged::Depth | Judged::Coverage);
        class(self.called.what).filter(of).map(|_| self.called.what)
    }
}

impl Dangers<'_> {
    /// What comes within `within_m` of each of `places` (east and north \[m\]), with how many of them: the kinds that
    /// close most places first. A place may be closed by several.
    pub fn closing(&self, places: &[[f64; 2]], within_m: f64) -> Vec<Closing> {
        // By class, name and cause, with whether they close each place.
        let mut kinds: BTreeMap<_, (Closing, Vec<bool>)> = BTreeMap::new();
        let mut count = |called: &Called, cause: Causes, is_near: &dyn Fn(&[f64; 2]) -> bool| {
            let near: Vec<bool> = places.iter().map(is_near).collect();
            if !near.contains(&true) {
                return;
            }
            let new = || (Closing { called: called.clone(), cause, places: 0 }, vec![false; places.len()]);
            let kind = (called.what, called.name.clone(), cause.bits());
            let (closing, closes) = kinds.entry(kind).or_insert_with(new);
            closes.iter_mut().zip(near).for_each(|(closes, near)| *closes |= near);
            closing.places = closes.iter().filter(|closes| **closes).count();
            let depths = closing.called.depth_m.into_iter().chain(called.depth_m);
            closing.called.depth_m = depths.reduce(f64::max);
        };
        for (polygon, cause) in &self.polygons {
            let is_near = |place: &[f64; 2]| gap_to(polygon, &[*place], within_m).distance_m < within_m;
            count(&polygon.called, *cause, &is_near);
        }
        if self.chart.uncharted() == Uncharted::Obstacle {
            let charted = &self.chart.charted().polygons;
            let is_near = |place: &[f64; 2]| {
                !charted.iter().any(|polygon| is_inside(polygon, *place))
                    || self.edge(*place, Gap::NONE).distance_m < within_m
            };
            count(&Called::plain("uncharted water"), Causes::UNCHARTED, &is_near);
        }
        let mut all: Vec<Closing> = kinds.into_values().map(|(closing, _)| closing).collect();
        all.sort_by_key(|closing| std::cmp::Reverse(closing.places));
        all
    }
}
