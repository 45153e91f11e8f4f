//! The rules of classes with the changes of `plan.toml`, and their application to an object.

use std::cmp::Ordering;
use std::collections::BTreeMap;

use crate::classes::{Ignored, Judged, Treatment, is, judged, of_class};
use crate::enc::{
    CATDIS, Feature, Geometry, ORIENT, Polygon, RESTRN, VERCCL, VERCLR, VERCSA, class, class_name,
};
use crate::ring::turn;
use crate::{DANGER_M, Invalid};

/// Radius of the danger around a point or line whose position is doubtful, unreliable, reported or estimated
/// \[m\]: the accuracy of zone of confidence C.
pub const DOUBTFUL_M: f64 = 500.0;
/// Positional accuracy of a chart: half a millimetre at its compilation scale \[m\].
const DRAWN_M: f64 = 0.5e-3;
/// Qualities of positions (QUAPOS) that are good enough for [`DANGER_M`]: surveyed, approximate (within 30
/// m), precisely known, calculated.
const GOOD: [u8; 4] = [1, 4, 10, 11];
/// Restrictions (RESTRN) that close an area: entry prohibited, entry restricted, to be avoided.
const CLOSED: [u16; 3] = [7, 8, 14];
/// A distance mark that is not physically there (CATDIS).
const UNMARKED: u16 = 1;
/// Restrictions that do not concern passing ships: no wake, stopping prohibited, speed restricted.
const PASSING: [u16; 3] = [13, 25, 27];

/// Settings that change or complete the table.
#[derive(Clone, Debug, Default)]
pub struct Rules {
    /// Classes by their acronym (or code, if the standard has none) with another treatment.
    pub changed: BTreeMap<String, Treatment>,
    /// The ship's air draught, including the required clearance \[m\]; if unknown, no bridge is high enough.
    pub air_draught_m: Option<f64>,
    /// Radius of the danger around points and lines \[m\]; [`DANGER_M`] by default.
    pub radius_m: Option<f64>,
    /// The same where a position is doubtful \[m\]; [`DOUBTFUL_M`] by default.
    pub doubtful_radius_m: Option<f64>,
}

impl Rules {
    /// Refuses changes of unknown classes, and of depths and coverage, which are judged by `safety` alone.
    ///
    /// # Errors
    /// Names the class.
    pub fn check(&self) -> Result<(), Invalid> {
        for (name, treatment) in &self.changed {
            let thing = format!("`rules.{name}`");
            let known = class(name).or_else(|| name.parse().ok().filter(|code| class_name(*code).is_none()));
            let Some(code) = known else {
                let names = (1..500).filter_map(class_name);
                return Err(Invalid {
                    expected: "an object class of S-57".into(),
                    ..Invalid::unknown(thing, name, names)
                });
            };
            let fixed = matches!(judged(code), Judged::Depth | Judged::Coverage);
            let sharp = matches!(judged(code), Judged::Danger | Judged::Sounding | Judged::Contour);
            let declared = format!("{treatment:?}");
            if fixed {
                let remedy =
                    "leave it out: depths are judged by `safety.transit_depth_m` and `safety.trial_depth_m`";
                return Err(Invalid::new(thing, declared, "no rule for depths and coverage", remedy));
            }
            if sharp && *treatment == Treatment::ManeuversAvoid {
                let remedy = "maneuvers have `safety.trial_depth_m` of their own";
                return Err(Invalid::new(thing, declared, "`avoid` or `ignore`", remedy));
            }
        }
        Ok(())
    }

    /// The treatment of an object in view of `land`, and why it has no effect if it has none.
    pub(crate) fn treatment(&self, feature: &Feature, land: &Land) -> Result<(Treatment, Ignored), Invalid> {
        let named = class_name(feature.class).map_or_else(|| feature.class.to_string(), str::to_owned);
        if let Some(changed) = self.changed.get(&named) {
            return Ok(match *changed != Treatment::Ignore && self.is_passed_under(feature)? {
                true => (Treatment::Ignore, Ignored::PassedUnder),
                false => (*changed, Ignored::Rule),
            });
        }
        let restrictions = feature.list(RESTRN);
        let any = |of: &[u16]| restrictions.iter().any(|r| of.contains(r));
        let usual = of_class(feature.class).map_or(Treatment::Avoid, |rule| rule.treatment);
        let ignored = of_class(feature.class).map_or(Ignored::NoBody, |rule| rule.ignored);
        let ignore = |why: Ignored| Ok((Treatment::Ignore, why));
        match () {
            () if self.is_passed_under(feature)? => ignore(Ignored::PassedUnder),
            () if any(&CLOSED) => Ok((Treatment::Avoid, ignored)),
            // Where lanes join, the chart has no direction.
            () if named == "TSSLPT" && feature.number(ORIENT)?.is_none() => Ok((Treatment::Avoid, ignored)),
            // Of a restricted area only its restrictions are known to matter.
            () if named == "RESARE" && !restrictions.is_empty() => match any(&PASSING) {
                true => Ok((Treatment::ManeuversAvoid, ignored)),
                false => ignore(Ignored::Restriction),
            },
            () if is(feature.class, "DISMAR") && feature.list(CATDIS) == [UNMARKED] => {
                ignore(Ignored::Unmarked)
            }
            () if judged(feature.class).stands() && land.holds(&feature.geometry) => ignore(Ignored::OnLand),
            () if any(&PASSING) => Ok((usual.max(Treatment::ManeuversAvoid), ignored)),
            () => Ok((usual, ignored)),
        }
    }

    /// The radius of an object's points and lines, on a chart of 1 to `scale` \[m\]; that of a danger if the
    /// scale is unknown.
    pub fn radius_m(&self, feature: &Feature, scale: Option<u32>) -> f64 {
        let drawn_m = scale.map_or(DANGER_M, |scale| DRAWN_M * f64::from(scale));
        let by_itself = matches!(judged(feature.class), Judged::Danger | Judged::Sounding);
        let is_point = matches!(feature.geometry, Geometry::Points(_));
        if !(by_itself || (is_point && judged(feature.class).reaches())) {
            return drawn_m;
        }
        let good = feature.position_quality.iter().all(|quality| GOOD.contains(quality));
        let radius_m = match good {
            true => self.radius_m.unwrap_or(DANGER_M),
            false => self.doubtful_radius_m.unwrap_or(DOUBTFUL_M),
        };
        radius_m.max(drawn_m)
    }

    /// Whether an object has a clearance and the ship passes under it.
    fn is_passed_under(&self, feature: &Feature) -> Result<bool, Invalid> {
        if judged(feature.class) != Judged::Clearance {
            return Ok(false);
        }
        // Opening bridges count as closed.
        let mut least: Option<f64> = None;
        for attribute in [VERCLR, VERCCL, VERCSA] {
            let number = feature.number(attribute)?;
            least = least.into_iter().chain(number).reduce(f64::min);
        }
        Ok(self.air_draught_m.zip(least).is_some_and(|(ship, clear)| ship <= clear))
    }
}

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
        let polygons = areas.filter_map(|area| match &area.geometry {
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
        let bounds = |(low, high): (f64, f64), latitude: f64| (low.min(latitude), high.max(latitude));
        let (south, north) = latitudes.fold((f64::INFINITY, f64::NEG_INFINITY), bounds);
        let height = (north - south).max(f64::MIN_POSITIVE);
        let copies: f64 = edges.iter().map(|edge| (edge.ends[0][1] - edge.ends[1][1]).abs() / height).sum();
        let count = edges.len() as f64;
        let bands = (count / PER_BAND).min(MOST_COPIES * count / copies.max(1.0)).floor().max(1.0);
        let mut banded =
            Self { south, bands_per_degree: bands / height, bands: vec![Vec::new(); bands as usize] };
        for edge in edges {
            for band in banded.band(edge.ends[0][1].min(edge.ends[1][1]))
                ..=banded.band(edge.ends[0][1].max(edge.ends[1][1]))
            {
                banded.bands[band].push(*edge);
            }
        }
        banded
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
        for edges in band.chunk_by(|a, b| a.polygon == b.polygon) {
            let mut inside = false;
            let mut on_edge = false;
            for Edge { ends: [a, b], .. } in edges {
                let within = |k: usize, v: f64| a[k].min(b[k]) <= v && v <= a[k].max(b[k]);
                if !within(1, y) || x > a[0].max(b[0]) {
                    continue;
                }
                let side = turn(*a, *b, [x, y]);
                on_edge |= side == Ordering::Equal && within(0, x);
                inside ^= (a[1] > y) != (b[1] > y) && (side == Ordering::Greater) == (b[1] > a[1]);
            }
            if inside && !on_edge {
                return Some(edges[0].polygon);
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
        let outline: Vec<Edge> = edges(0, std::slice::from_ref(outer)).collect();
        let area = Self::banded(&outline);
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
