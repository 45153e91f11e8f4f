use std::borrow::Cow;

use serde::Deserialize;

use crate::frontier::frontier;
use crate::{
    Area, Bounds, Called, Class, Contour, Grid, Invalid, PlacedGrid, Plane, Polygon, PolygonLayer, Spot,
};

/// Points and lines between two looks at the clock.
const AT_ONCE: usize = 1000;

/// What places that no layer charts are.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Uncharted {
    /// Unknown water is not safe: the default of charts with a depth layer.
    Obstacle,
    /// Water is whatever is not land or no-go: the default of charts without depths.
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

/// What is known of an area: polygons and grids on one plane.
///
/// Nothing is known outside the area: obstacles are everywhere there. Choose it larger than where the ship
/// sails by the largest margin, so that land just outside is seen.
#[derive(Clone, Debug)]
pub struct Chart {
    plane: Plane,
    area: Bounds,
    uncharted: Uncharted,
    polygons: Vec<Polygon>,
    spots: Vec<Spot>,
    contours: Vec<Contour>,
    grids: Vec<PlacedGrid>,
    charted: Charted,
    known_by: KnownBy,
}

/// What says of a place what is there.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum KnownBy {
    /// Depths: what neither they nor land cover is not known.
    Depths,
    /// A chart of land in polygons: the rest is water.
    Land,
    /// Neither: grids of land and water, as far as they reach.
    Grids,
}

/// Where there is a depth: what the charted polygons cover, and the edges with nothing charted beyond.
#[derive(Clone, Debug)]
pub(crate) struct Charted {
    pub polygons: Vec<Polygon>,
    pub frontier: Vec<[[f64; 2]; 2]>,
}

impl Chart {
    /// Places the layers on the plane and keeps what meets the area.
    ///
    /// `uncharted`: what places without any layer are. By default they are obstacles as soon as there is a
    /// layer of depths, and water otherwise. With depths, a place is charted where a depth or land polygon
    /// or a depth grid covers it; cells without data of a grid are obstacles whatever another layer says.
    ///
    /// # Errors
    /// No layer; polygons off the earth or a grid of another size than it says (neither comes from a file);
    /// a grid whose coordinates are outside its CRS; uncharted obstacles without a layer of depths (nothing
    /// would be water).
    pub fn new(
        plane: Plane,
        area: Bounds,
        layers: &[Layer],
        uncharted: Option<Uncharted>,
    ) -> Result<Self, Invalid> {
        let whole = Self::new_while(plane, area, layers, uncharted, &|| true)?;
        let Some(whole) = whole else { unreachable!("nobody says no") };
        Ok(whole)
    }

    /// The same, while `go_on` says so; `None` where it did not.
    ///
    /// # Errors
    /// As [`Chart::new`].
    pub fn new_while(
        plane: Plane,
        area: Bounds,
        layers: &[Layer],
        uncharted: Option<Uncharted>,
        go_on: &dyn Fn() -> bool,
    ) -> Result<Option<Self>, Invalid> {
        let uncharted = uncharted_of(layers, uncharted)?;
        let mut polygons = Vec::new();
        let (mut spots, mut contours, mut grids) = (Vec::new(), Vec::new(), Vec::new());
        for layer in layers {
            let layer = match layer {
                Layer::Polygons(layer) => layer,
                Layer::Grid(grid) => {
                    grids.extend(PlacedGrid::place(grid, &plane, &area)?);
                    continue;
                }
            };
            for area_of_file in &layer.areas {
                if !go_on() {
                    return Ok(None);
                }
                let placed = Polygon::place(area_of_file, &plane).ok_or_else(|| off_earth(area_of_file))?;
                polygons.extend(Some(placed).filter(|p| p.bounds.meets(&area)));
            }
            let lines = layer.contours.iter();
            contours.extend(lines.filter_map(|line| Contour::place(line, &plane, &area)));
            for marks in layer.marks.chunks(AT_ONCE) {
                if !go_on() {
                    return Ok(None);
                }
                let own = marks.iter().filter_map(|mark| Spot::place(mark, &plane));
                spots.extend(own.filter(|spot| area.contains(spot.place)));
                let around = |mark| Polygon::around(mark, &plane);
                polygons.extend(marks.iter().flat_map(around).filter(|p| p.bounds.meets(&area)));
            }
        }
        let charted = match uncharted {
            _ if !go_on() => return Ok(None),
            Uncharted::Obstacle => charted(&polygons, &grids),
            Uncharted::Water => Charted { polygons: Vec::new(), frontier: Vec::new() },
        };
        let known_by = KnownBy::of(layers);
        Ok(Some(Self { plane, area, uncharted, polygons, spots, contours, grids, charted, known_by }))
    }

    /// The plane that everything is on.
    pub fn plane(&self) -> &Plane {
        &self.plane
    }

    /// The area that is charted.
    pub fn area(&self) -> Bounds {
        self.area
    }

    /// What places without any layer are.
    pub fn uncharted(&self) -> Uncharted {
        self.uncharted
    }

    /// Bytes that it takes beside its grids, about.
    pub fn bytes(&self) -> u64 {
        let polygon = |own: &Polygon| {
            let rings = own.rings.iter().map(|ring| size_of_val(&ring[..]) + size_of_val(ring));
            size_of_val(own) + rings.sum::<usize>()
        };
        let polygons = self.polygons.iter().chain(&self.charted.polygons).map(polygon);
        let contours = self.contours.iter().map(|own| size_of_val(own) + size_of_val(&own.line[..]));
        let places = size_of_val(&self.charted.frontier[..]) + size_of_val(&self.spots[..]);
        (polygons.chain(contours).sum::<usize>() + places) as u64
    }

    /// Bytes of its grids, which stand in memory once: as they were read.
    pub fn grid_bytes(&self) -> u64 {
        self.grids.iter().map(PlacedGrid::bytes).sum::<usize>() as u64
    }

    /// Polygons that meet the area, whole, in the order of the layers; those around points and lines after a layer's own.
    pub fn polygons(&self) -> &[Polygon] {
        &self.polygons
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

    /// Whether any depth is known; otherwise land is all that is avoided, and its shoals need a margin.
    pub fn has_depth(&self) -> bool {
        let depth = |p: &Polygon| matches!(p.class, Class::Depth { .. });
        self.polygons.iter().any(depth) || self.grids.iter().any(|g| g.has_depth)
    }

    /// Whether some of it is for getting about only, free of informative maneuvers.
    pub fn has_transit_only(&self) -> bool {
        self.polygons.iter().any(|p| p.class == Class::TransitOnly)
    }

    /// Polygons cut to `bounds`, for drawing: rings to fill by the even-odd rule. Where a cut polygon falls
    /// into parts, thin bridges run along the cut.
    pub fn drawn(&self, bounds: &Bounds) -> Vec<Polygon> {
        let cut = |p: &Polygon| {
            let rings = p.rings.iter().map(|r| crate::clip::clip_ring(r, bounds)).filter(|r| r.len() > 2);
            let cut = Polygon::of_rings(p.class, &p.called, rings.collect())?;
            Some(Polygon { is_of_point: p.is_of_point, ..cut })
        };
        self.polygons.iter().filter(|p| p.bounds.meets(bounds)).filter_map(cut).collect()
    }

    pub(crate) fn charted(&self) -> &Charted {
        &self.charted
    }

    /// What is charted, whatever places without any layer are; `None` where that is all.
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
        let land = |layer: &Layer| matches!(layer, Layer::Polygons(own) if own.open_sea);
        if layers.iter().any(|own| depth(own) || has(own, |class| matches!(class, Class::Depth { .. }))) {
            Self::Depths
        } else if layers.iter().any(|own| land(own) || has(own, |class| *class == Class::Land)) {
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

/// What a grid covers.
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

fn uncharted_of(layers: &[Layer], asked: Option<Uncharted>) -> Result<Uncharted, Invalid> {
    if layers.is_empty() {
        return Err(Invalid::new("chart", "no layer", "at least one layer", "name a file of land or depths"));
    }
    match (asked, KnownBy::of(layers) == KnownBy::Depths) {
        (Some(Uncharted::Obstacle), false) => Err(Invalid::new(
            "`uncharted`",
            "`obstacle` without a layer of depths",
            "a layer of depths, or `water`",
            "add depths, or let water be whatever is not land",
        )),
        (Some(asked), _) => Ok(asked),
        (None, true) => Ok(Uncharted::Obstacle),
        (None, false) => Ok(Uncharted::Water),
    }
}

fn charted(polygons: &[Polygon], grids: &[PlacedGrid]) -> Charted {
    let known = polygons.iter().filter(|p| matches!(p.class, Class::Land | Class::Depth { .. })).cloned();
    Charted::new(known.chain(grids.iter().filter(|g| g.has_depth).filter_map(frame)).collect())
}
