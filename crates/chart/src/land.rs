//! Which objects stand on land: within the land areas of their own chart.

use std::cmp::Ordering;

use crate::enc::{Feature, Geometry, Polygon};

use crate::classes::is;
use crate::orientation::turn;

/// Approximate edges per band, and average number of bands per edge at most.
const PER_BAND: f64 = 16.0;
const MOST_COPIES: f64 = 4.0;

/// An edge of a land area, with the index of its polygon.
#[derive(Clone, Copy)]
struct Edge {
    polygon: usize,
    ends: [[f64; 2]; 2],
}

/// Land areas, their edges sorted into bands of latitude.
pub(crate) struct Land {
    south: f64,
    bands_per_degree: f64,
    bands: Vec<Vec<Edge>>,
}

impl Land {
    /// The land areas among objects; points and lines of land contain nothing.
    pub(crate) fn of(objects: &[Feature]) -> Self {
        let areas = objects.iter().filter(|object| is(object.class, "LNDARE"));
        let polygons = areas.filter_map(|own| match &own.geometry {
            Geometry::Area(polygons) => Some(polygons),
            _ => None,
        });
        let polygons: Vec<&Polygon> = polygons.flatten().collect();
        let edges: Vec<Edge> =
            polygons.iter().enumerate().flat_map(|(k, polygon)| edges(k, polygon)).collect();
        Self::banded(&edges)
    }

    fn banded(edges: &[Edge]) -> Self {
        let latitudes = edges.iter().flat_map(|edge| edge.ends.map(|end| end[1]));
        let bounds = |(low, high): (f64, f64), own: f64| (low.min(own), high.max(own));
        let (south, north) = latitudes.fold((f64::INFINITY, f64::NEG_INFINITY), bounds);
        let height = (north - south).max(f64::MIN_POSITIVE);
        let copies: f64 = edges.iter().map(|edge| (edge.ends[0][1] - edge.ends[1][1]).abs() / height).sum();
        let count = edges.len() as f64;
        let bands = (count / PER_BAND).min(MOST_COPIES * count / copies.max(1.0)).floor().max(1.0);
        let mut own =
            Self { south, bands_per_degree: bands / height, bands: vec![Vec::new(); bands as usize] };
        for edge in edges {
            for band in own.band(edge.ends[0][1].min(edge.ends[1][1]))
                ..=own.band(edge.ends[0][1].max(edge.ends[1][1]))
            {
                own.bands[band].push(*edge);
            }
        }
        own
    }

    fn band(&self, latitude: f64) -> usize {
        // The conversion maps negative numbers and NaN to 0.
        (((latitude - self.south) * self.bands_per_degree) as usize).min(self.bands.len() - 1)
    }

    /// Whether all of an object stands on land, not on its edge.
    pub(crate) fn holds(&self, geometry: &Geometry) -> bool {
        match geometry {
            Geometry::None | Geometry::Soundings(_) => false,
            Geometry::Points(points) => points.iter().all(|place| self.containing(*place).is_some()),
            Geometry::Lines(lines) => lines.iter().all(|line| self.holds_line(line).is_some()),
            Geometry::Area(polygons) => polygons.iter().all(|polygon| self.holds_area(polygon)),
        }
    }

    /// The land that contains a place in its interior.
    fn containing(&self, [x, y]: [f64; 2]) -> Option<usize> {
        let band = &self.bands[self.band(y)];
        for own in band.chunk_by(|a, b| a.polygon == b.polygon) {
            let mut inside = false;
            let mut on_edge = false;
            for Edge { ends: [a, b], .. } in own {
                let within = |k: usize, v: f64| a[k].min(b[k]) <= v && v <= a[k].max(b[k]);
                if !within(1, y) || x > a[0].max(b[0]) {
                    continue;
                }
                let side = turn(*a, *b, [x, y]);
                on_edge |= side == Ordering::Equal && within(0, x);
                inside ^= (a[1] > y) != (b[1] > y) && (side == Ordering::Greater) == (b[1] > a[1]);
            }
            if inside && !on_edge {
                return Some(own[0].polygon);
            }
        }
        None
    }

    /// The land that contains a line in its interior.
    fn holds_line(&self, line: &[[f64; 2]]) -> Option<usize> {
        let land = self.containing(*line.first()?)?;
        let whole = line.iter().all(|place| self.containing(*place) == Some(land));
        let touched = |pair: &[[f64; 2]]| {
            let near = self.between(pair[0][1], pair[1][1]).filter(|edge| edge.polygon == land);
            near.into_iter().any(|edge| touch([pair[0], pair[1]], edge.ends))
        };
        (whole && !line.windows(2).any(touched)).then_some(land)
    }

    /// Whether an area is surrounded by land and all of it is land.
    fn holds_area(&self, polygon: &Polygon) -> bool {
        let Some(outer) = polygon.first() else { return false };
        let Some(land) = self.holds_line(outer) else { return false };
        let [south, north] =
            [f64::min, f64::max].map(|pick| outer.iter().map(|p| p[1]).reduce(pick).unwrap_or(0.0));
        let own: Vec<Edge> = edges(0, std::slice::from_ref(outer)).collect();
        let area = Self::banded(&own);
        !self
            .between(south, north)
            .any(|edge| edge.polygon == land && area.containing(edge.ends[0]).is_some())
    }

    /// Edges in the bands between two latitudes, some more than once.
    fn between(&self, a: f64, b: f64) -> impl Iterator<Item = &Edge> {
        self.bands[self.band(a.min(b))..=self.band(a.max(b))].iter().flatten()
    }
}

fn edges(polygon: usize, rings: &[Vec<[f64; 2]>]) -> impl Iterator<Item = Edge> {
    rings.iter().flat_map(move |ring| ring.windows(2).map(move |w| Edge { polygon, ends: [w[0], w[1]] }))
}

/// Whether two edges have a point in common.
fn touch([p, q]: [[f64; 2]; 2], [r, s]: [[f64; 2]; 2]) -> bool {
    let apart = |k: usize| p[k].max(q[k]) < r[k].min(s[k]) || r[k].max(s[k]) < p[k].min(q[k]);
    let one_side = |a: Ordering, b: Ordering| a == b && a != Ordering::Equal;
    !(apart(0)
        || apart(1)
        || one_side(turn(p, q, r), turn(p, q, s))
        || one_side(turn(r, s, p), turn(r, s, q)))
}
