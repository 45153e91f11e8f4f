use std::borrow::Cow;
use std::collections::HashSet;

use schemars::JsonSchema;
use serde::Deserialize;

use crate::{
    Area, Bounds, Called, Class, Contour, Grid, Invalid, PlacedGrid, Plane, Polygon, PolygonLayer, Spot,
    Traffic,
};

/// Points and lines between two checks of the time limit.
const AT_ONCE: usize = 1000;

/// Classes of anchorages.
const ANCHORAGES: [&str; 2] = ["ACHARE", "ACHBRT"];

/// How places that no layer charts are treated.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Uncharted {
    /// Unknown water is not safe: the default for charts with a depth layer.
    Obstacle,
    /// Everything but land and no-go is water: the default for charts without depths.
    Water,
}

/// One layer of a chart.
#[derive(Clone, Debug)]
pub enum Layer {
    /// Polygons in longitude and latitude.
    Polygons(PolygonLayer),
    /// A grid in a declared CRS.
    Grid(Grid),
}

/// The knowledge of an area: polygons and grids on one plane.
///
/// Nothing is known outside the area: it is all obstacles. Choose an area that exceeds the ship's by the
/// largest margin, so that land just outside is included.
#[derive(Clone, Debug)]
pub struct Chart {
    plane: Plane,
    area: Bounds,
    uncharted: Uncharted,
    polygons: Vec<Polygon>,
    spots: Vec<Spot>,
    contours: Vec<Contour>,
    noted: Vec<(Option<Traffic>, Polygon)>,
    grids: Vec<PlacedGrid>,
    charted: Charted,
    known_by: KnownBy,
}

/// The layers that decide what a place is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum KnownBy {
    /// Depths: what neither they nor land cover is unknown.
    Depths,
    /// A chart of land in polygons: the rest is water.
    Land,
    /// Neither: grids of land and water, within their extent.
    Grids,
}

/// Where depths are charted: the area covered by polygons, and its outer edges.
#[derive(Clone, Debug)]
pub(crate) struct Charted {
    pub polygons: Vec<Polygon>,
    pub frontier: Vec<[[f64; 2]; 2]>,
}

impl Chart {
    /// Places the layers on the plane and keeps what meets the area.
    ///
    /// `uncharted` says what places without any layer are. By default they are obstacles as soon as there is
    /// a layer of depths, and water otherwise. With depths, a place is charted where a depth or land polygon
    /// or a depth grid covers it; cells without data are obstacles regardless of other layers.
    /// # Errors
    /// No layer; polygons off the earth or a grid of another size than declared (neither comes from a file);
    /// a grid whose coordinates are outside its CRS; uncharted obstacles without a layer of depths (no water
    /// would remain).
    pub fn new(
        plane: Plane,
        area: Bounds,
        layers: &[Layer],
        uncharted: Option<Uncharted>,
    ) -> Result<Self, Invalid> {
        let whole = Self::new_while(plane, area, layers, uncharted, &|| true)?;
        let Some(whole) = whole else { unreachable!("there is no time limit") };
        Ok(whole)
    }

    /// [`Chart::new`] under a time limit; `None` once `keep_going` returns false.
    ///
    /// # Errors
    /// As [`Chart::new`].
    pub fn new_while(
        plane: Plane,
        area: Bounds,
        layers: &[Layer],
        uncharted: Option<Uncharted>,
        keep_going: &dyn Fn() -> bool,
    ) -> Result<Option<Self>, Invalid> {
        let uncharted = uncharted_of(layers, uncharted)?;
        let mut polygons = Vec::new();
        let (mut spots, mut contours, mut grids) = (Vec::new(), Vec::new(), Vec::new());
        let mut noted = Vec::new();
        for layer in layers {
            let layer = match layer {
                Layer::Polygons(layer) => layer,
                Layer::Grid(grid) => {
                    grids.extend(PlacedGrid::place(grid, &plane, &area)?);
                    continue;
                }
            };
            for area_of_file in &layer.areas {
                if !keep_going() {
                    return Ok(None);
                }
                let placed = Polygon::place(area_of_file, &plane).ok_or_else(|| off_earth(area_of_file))?;
                polygons.extend(Some(placed).filter(|p| p.bounds.meets(&area)));
            }
            let lines = layer.contours.iter();
            contours.extend(lines.filter_map(|line| Contour::place(line, &plane, &area)));
            for object in &layer.noted {
                let areas = object.areas.iter().filter_map(|area| Polygon::place(area, &plane));
                let marks = object.marks.iter().flat_map(|mark| Polygon::buffer(mark, &plane));
                let near = areas.chain(marks).filter(|p| p.bounds.meets(&area));
                noted.extend(near.map(|polygon| (object.traffic, polygon)));
            }
            for marks in layer.marks.chunks(AT_ONCE) {
                if !keep_going() {
                    return Ok(None);
                }
                let placed = marks.iter().filter_map(|mark| Spot::place(mark, &plane));
                spots.extend(placed.filter(|spot| area.contains(spot.place)));
                let buffer = |mark| Polygon::buffer(mark, &plane);
                polygons.extend(marks.iter().flat_map(buffer).filter(|p| p.bounds.meets(&area)));
            }
        }
        let charted = match uncharted {
            _ if !keep_going() => return Ok(None),
            Uncharted::Obstacle => charted(&polygons, &grids),
            Uncharted::Water => Charted { polygons: Vec::new(), frontier: Vec::new() },
        };
        let known_by = KnownBy::of(layers);
        let noted = between_lanes(noted);
        Ok(Some(Self { plane, area, uncharted, polygons, spots, contours, noted, grids, charted, known_by }))
    }

    /// The plane that everything is on.
    pub fn plane(&self) -> &Plane {
        &self.plane
    }

    /// The area that is charted.
    pub fn area(&self) -> Bounds {
        self.area
    }

    /// How places without any layer are treated.
    pub fn uncharted(&self) -> Uncharted {
        self.uncharted
    }

    /// Approximate bytes of memory, without its grids.
    pub fn bytes(&self) -> u64 {
        let polygon = |polygon: &Polygon| {
            let rings = polygon.rings.iter().map(|ring| size_of_val(&ring[..]) + size_of_val(ring));
            size_of_val(polygon) + rings.sum::<usize>()
        };
        let noted = self.noted.iter().map(|(_, polygon)| polygon);
        let polygons = self.polygons.iter().chain(&self.charted.polygons).chain(noted).map(polygon);
        let contours =
            self.contours.iter().map(|contour| size_of_val(contour) + size_of_val(&contour.line[..]));
        let places = size_of_val(&self.charted.frontier[..]) + size_of_val(&self.spots[..]);
        (polygons.chain(contours).sum::<usize>() + places) as u64
    }

    /// Bytes of its grids, which are in memory once, as they were read.
    pub fn grid_bytes(&self) -> u64 {
        self.grids.iter().map(PlacedGrid::bytes).sum::<usize>() as u64
    }

    /// Whole polygons that meet the area, in the order of the layers; those around points and lines follow a layer's own.
    pub fn polygons(&self) -> &[Polygon] {
        &self.polygons
    }

    /// Where the traffic has a direction.
    pub fn traffic(&self) -> impl Iterator<Item = (Traffic, &Polygon)> {
        self.noted.iter().filter_map(|(traffic, polygon)| Some(((*traffic)?, polygon)))
    }

    pub(crate) fn noted(&self) -> &[(Option<Traffic>, Polygon)] {
        &self.noted
    }

    /// The chart without the areas of some classes that maneuvers or ships keep out of.
    #[must_use]
    pub fn without(&self, classes: &[&str]) -> Self {
        let mut open = self.clone();
        let closes = |p: &Polygon| matches!(p.class, Class::TransitOnly | Class::NoGo);
        open.polygons.retain(|p| !(closes(p) && classes.contains(&p.called.what)));
        open
    }

    /// Charted points in the area.
    pub fn spots(&self) -> &[Spot] {
        &self.spots
    }

    /// Charted lines of one depth that meet the area.
    pub fn contours(&self) -> &[Contour] {
        &self.contours
    }

    /// Grids, cut to the area with up to two cells to spare.
    pub fn grids(&self) -> &[PlacedGrid] {
        &self.grids
    }

    /// Whether any depth is known; otherwise only land is avoided, and shoals off it need a margin.
    pub fn has_depth(&self) -> bool {
        let depth = |p: &Polygon| matches!(p.class, Class::Depth { .. });
        self.polygons.iter().any(depth) || self.grids.iter().any(|g| g.has_depth)
    }

    /// Whether parts of it are for transit only, closed to informative maneuvers.
    pub fn has_transit_only(&self) -> bool {
        self.polygons.iter().any(|p| p.class == Class::TransitOnly)
    }

    /// Charted anchorages that ships may pass.
    pub fn anchorages(&self) -> impl Iterator<Item = &Polygon> {
        let is_one = |p: &&Polygon| ANCHORAGES.contains(&p.called.what) && p.class == Class::TransitOnly;
        self.polygons.iter().filter(is_one)
    }

    /// Polygons clipped to `bounds`, for drawing: rings to fill by the even-odd rule. Where a clipped polygon
    /// falls apart, thin bridges run along the clip edge.
    pub fn drawn(&self, bounds: &Bounds) -> Vec<Polygon> {
        let cut = |p: &Polygon| {
            let rings = p.rings.iter().map(|r| clip_ring(r, bounds)).filter(|r| r.len() > 2);
            let cut = Polygon::of_rings(p.class, &p.called, rings.collect())?;
            Some(Polygon { is_of_point: p.is_of_point, ..cut })
        };
        self.polygons.iter().filter(|p| p.bounds.meets(bounds)).filter_map(cut).collect()
    }

    pub(crate) fn charted(&self) -> &Charted {
        &self.charted
    }

    /// The charted area, regardless of how places without any layer are treated; `None` where everything is charted.
    pub(crate) fn covered(&self) -> Option<Cow<'_, Charted>> {
        match (self.known_by, self.uncharted) {
            (KnownBy::Land, _) => None,
            (KnownBy::Depths, Uncharted::Obstacle) => Some(Cow::Borrowed(&self.charted)),
            (KnownBy::Depths, Uncharted::Water) => Some(Cow::Owned(charted(&self.polygons, &self.grids))),
            (KnownBy::Grids, _) => {
                let frames = self.grids.iter().filter_map(frame);
                Some(Cow::Owned(Charted::new(frames.collect())))
            }
        }
    }
}

impl KnownBy {
    fn of(layers: &[Layer]) -> Self {
        let has = |layer: &Layer, is: fn(&Class) -> bool| match layer {
            Layer::Polygons(p) => p.areas.iter().any(|area| is(&area.class)),
            Layer::Grid(_) => false,
        };
        let depth = |layer: &Layer| matches!(layer, Layer::Grid(grid) if grid.has_depth);
        let land = |layer: &Layer| matches!(layer, Layer::Polygons(layer) if layer.open_sea);
        if layers.iter().any(|layer| depth(layer) || has(layer, |class| matches!(class, Class::Depth { .. })))
        {
            Self::Depths
        } else if layers.iter().any(|layer| land(layer) || has(layer, |class| *class == Class::Land)) {
            Self::Land
        } else {
            Self::Grids
        }
    }
}

impl Charted {
    fn new(polygons: Vec<Polygon>) -> Self {
        let frontier = frontier(&polygons);
        Self { polygons, frontier }
    }
}

/// The outline of a grid.
fn frame(grid: &PlacedGrid) -> Option<Polygon> {
    Polygon::of_rings(Class::Depth { least_m: None }, &Called::plain("water"), vec![grid.frame()?])
}

fn off_earth(area: &Area) -> Invalid {
    Invalid::new(
        format!("feature {}", area.feature),
        "no position, or one off the earth",
        "longitude within ±180 and latitude within ±90",
        "read it from a file",
    )
}

fn uncharted_of(layers: &[Layer], declared: Option<Uncharted>) -> Result<Uncharted, Invalid> {
    if layers.is_empty() {
        return Err(Invalid::new("chart", "no layer", "at least one layer", "name a file of land or depths"));
    }
    match (declared, KnownBy::of(layers) == KnownBy::Depths) {
        (Some(Uncharted::Obstacle), false) => Err(Invalid::new(
            "`uncharted`",
            "`obstacle` without a layer of depths",
            "a layer of depths, or `water`",
            "add depths, or set it to `water`",
        )),
        (Some(declared), _) => Ok(declared),
        (None, true) => Ok(Uncharted::Obstacle),
        (None, false) => Ok(Uncharted::Water),
    }
}

fn charted(polygons: &[Polygon], grids: &[PlacedGrid]) -> Charted {
    let known = polygons.iter().filter(|p| matches!(p.class, Class::Land | Class::Depth { .. })).cloned();
    Charted::new(known.chain(grids.iter().filter(|g| g.has_depth).filter_map(frame)).collect())
}

/// Gives every zone the direction of the lane that is nearest to it.
fn between_lanes(mut all: Vec<(Option<Traffic>, Polygon)>) -> Vec<(Option<Traffic>, Polygon)> {
    let of_lane = |(traffic, polygon): &(Option<Traffic>, Polygon)| match traffic {
        Some(Traffic::Lane(towards)) => Some((*towards, polygon.clone())),
        _ => None,
    };
    let lanes: Vec<(f64, Polygon)> = all.iter().filter_map(of_lane).collect();
    for (traffic, polygon) in &mut all {
        let Some(Traffic::Zone(of)) = traffic else { continue };
        let least = |a: &Polygon, b: &Polygon| {
            b.rings.iter().flatten().map(|place| -a.inside_m(*place)).fold(f64::INFINITY, f64::min)
        };
        let gap_m = |lane: &Polygon| least(lane, polygon).min(least(polygon, lane));
        *of = lanes.iter().min_by(|a, b| gap_m(&a.1).total_cmp(&gap_m(&b.1))).map(|(towards, _)| *towards);
    }
    all
}

type Directed = [[u64; 2]; 2];

/// Edges with a charted polygon on one side only. Neighbours share a border when both have the same corners
/// on it, as the cells of electronic charts do; otherwise the border counts as uncharted on either side.
fn frontier(polygons: &[Polygon]) -> Vec<[[f64; 2]; 2]> {
    let edges = || polygons.iter().flat_map(Polygon::edges);
    let known: HashSet<Directed> = edges().map(directed).collect();
    let open = |edge: &[[f64; 2]; 2]| {
        let [from, to] = directed(*edge);
        !known.contains(&[to, from])
    };
    edges().filter(open).collect()
}

/// The bits of an edge's ends; adding zero normalizes negative zero.
fn directed(edge: [[f64; 2]; 2]) -> Directed {
    edge.map(|p| p.map(|v| (v + 0.0).to_bits()))
}

// Rings cut to a box (Sutherland and Hodgman 1974).

/// The part of a ring (not closed) inside the box, closed along the sides of the box; empty if there is none.
fn clip_ring(ring: &[[f64; 2]], bounds: &Bounds) -> Vec<[f64; 2]> {
    let sides = [(0, bounds.min[0], 1.0), (0, bounds.max[0], -1.0), (1, bounds.min[1], 1.0)];
    let sides = sides.into_iter().chain([(1, bounds.max[1], -1.0)]);
    sides.fold(ring.to_vec(), |ring, (axis, limit, sign)| half(&ring, axis, limit, sign))
}

/// The part where `sign · (p[axis] − limit) ≥ 0`.
fn half(ring: &[[f64; 2]], axis: usize, limit: f64, sign: f64) -> Vec<[f64; 2]> {
    let inside = |p: &[f64; 2]| sign * (p[axis] - limit) >= 0.0;
    let mut kept = Vec::with_capacity(ring.len() + 4);
    for (i, q) in ring.iter().enumerate() {
        let p = &ring[(i + ring.len() - 1) % ring.len()];
        if inside(p) != inside(q) {
            kept.push(cut(p, q, axis, limit));
        }
        if inside(q) {
            kept.push(*q);
        }
    }
    kept
}

fn cut(p: &[f64; 2], q: &[f64; 2], axis: usize, limit: f64) -> [f64; 2] {
    let t = (limit - p[axis]) / (q[axis] - p[axis]);
    let other = 1 - axis;
    let mut point = [limit; 2];
    point[other] = p[other] + t * (q[other] - p[other]);
    point
}
