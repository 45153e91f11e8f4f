use std::io::{BufReader, Read};

use geojson::{Feature, GeoJson, GeometryValue, JsonObject, JsonValue, PolygonType, Position};
use schemars::JsonSchema;
use serde::Deserialize;

use crate::classes::Called;
use crate::grid::FARTHEST;
use crate::ring::{RingFault, ring_fault_while};
use crate::{Crs, DepthUnit, Invalid, Reading, Traffic, Unread};

/// Default radius of the danger around a charted point or line \[m\]: the positional accuracy of older surveys.
pub const DANGER_M: f64 = 50.0;

/// Features, and bytes, between two checks of the time limit.
const AT_ONCE: usize = 1000;
const AT_ONCE_BYTES: usize = 1 << 16;

/// What the polygons of a file are.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum LayerKind {
    /// Land, piers, pontoons: never water.
    Land,
    /// Water that the plan avoids.
    NoGo,
    /// Areas of a known least depth.
    Depth {
        /// Property with the least depth \[m, positive down\], such as `DRVAL1`. A feature where it is null
        /// has an unknown depth and is an obstacle.
        least: String,
    },
    /// Wrecks, rocks and obstructions: passable only where the depth over them is known and sufficient.
    Danger {
        /// Property with the depth over them \[m, positive down\], such as `VALSOU`.
        least: String,
    },
}

/// Which features of a file belong to the layer: those whose `property` is one of `values`.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Filter {
    /// The property, such as `objl`.
    pub property: String,
    /// Its values as text (`DEPARE`, or `42` where the file has numbers).
    pub values: Vec<String>,
}

/// What a polygon is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Class {
    /// Land.
    Land,
    /// Keep out.
    NoGo,
    /// Informative maneuvers keep out; others may pass.
    TransitOnly,
    /// Water of a least depth.
    Depth {
        /// Least depth \[m, positive down\]; `None`: unknown, an obstacle at any least depth.
        least_m: Option<f64>,
    },
    /// An underwater danger. It does not chart the water around it: its depth is not the water's.
    Danger {
        /// Depth over it \[m, positive down\]; `None`: unknown, an obstacle at any least depth.
        least_m: Option<f64>,
    },
}

/// Polygons, points and lines of one kind, WGS84.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PolygonLayer {
    /// The polygons, in the order of the file.
    pub areas: Vec<Area>,
    /// The points and lines, in the order of the file.
    pub marks: Vec<Mark>,
    /// Lines of one depth: for maps.
    pub contours: Vec<Contour>,
    /// Objects that the crew has to know about.
    pub noted: Vec<Noted>,
    /// Features that the filter left out.
    pub filtered_out: usize,
    /// Set where an area that contains none of it is open sea and not another place.
    pub open_sea: bool,
}

impl Class {
    /// In a word.
    fn word(self) -> &'static str {
        match self {
            Self::Land => "land",
            Self::NoGo | Self::TransitOnly => "no-go area",
            Self::Depth { .. } => "water",
            Self::Danger { .. } => "danger",
        }
    }

    /// The depth of it or over it, if known \[m\].
    pub(crate) fn depth_m(self) -> Option<f64> {
        match self {
            Self::Depth { least_m } | Self::Danger { least_m } => least_m,
            Self::Land | Self::NoGo | Self::TransitOnly => None,
        }
    }
}

/// A point, or a line.
#[derive(Clone, Debug, PartialEq)]
pub struct Mark {
    /// What it is.
    pub class: Class,
    /// Its name.
    pub called: Called,
    /// Whether it is a sounding, and not an object.
    pub sounding: bool,
    /// Longitude and latitude \[deg\] of the point, or of the line's corners.
    pub positions: Vec<[f64; 2]>,
    /// The radius of its effect \[m\].
    pub radius_m: f64,
    /// Index of the feature in the file.
    pub feature: usize,
}

/// An object that the crew has to know about; its points and lines have the radius of their marks.
#[derive(Clone, Debug, PartialEq)]
pub struct Noted {
    /// Its traffic, if that has a direction.
    pub traffic: Option<Traffic>,
    /// Its areas.
    pub areas: Vec<Area>,
    /// Its points and lines.
    pub marks: Vec<Mark>,
}

/// A depth contour: it is drawn, and blocks nothing by itself.
#[derive(Clone, Debug, PartialEq)]
pub struct Contour {
    /// Depth \[m\], if known.
    pub depth_m: Option<f64>,
    /// Its corners: longitude and latitude \[deg\] in a layer, east and north \[m\] on the plane of a chart.
    pub line: Vec<[f64; 2]>,
}

/// One polygon: the outer ring, then its holes.
#[derive(Clone, Debug, PartialEq)]
pub struct Area {
    /// What it is.
    pub class: Class,
    /// Its name.
    pub called: Called,
    /// Rings of (longitude, latitude) \[deg\], closed: the last position repeats the first.
    pub rings: Vec<Vec<[f64; 2]>>,
    /// Index of the feature in the file.
    pub feature: usize,
}

impl PolygonLayer {
    /// Reads GeoJSON (RFC 7946) of any geometry, with depths in metres. As [`PolygonLayer::read`].
    ///
    /// # Errors
    /// As [`PolygonLayer::read`].
    pub fn from_geojson(text: &str, kind: &LayerKind, filter: Option<&Filter>) -> Result<Self, Invalid> {
        Self::read(text, (kind, DepthUnit::Metre), filter, &Reading::whole()).map_err(Unread::into_invalid)
    }

    /// Reads GeoJSON (RFC 7946) of any geometry, with depths in any unit. Points and lines are dangers within [`DANGER_M`],
    /// unless [`PolygonLayer::with_danger`] sets another radius; in a layer of depths they have a depth, and chart no water.
    ///
    /// # Errors
    /// Corrupt JSON; a `crs` member other than WGS84 or coordinates outside ±180 and ±90; features without a
    /// geometry; no features left; an empty or open ring, one that crosses itself or another of its polygon
    /// (features that the filter leaves out are not checked); a depth property that no feature has or that is
    /// not a number, or a depth that no sea has; depths that are all negative. Files that exceed the time
    /// limit.
    pub fn read(
        text: &str,
        (kind, unit): (&LayerKind, DepthUnit),
        filter: Option<&Filter>,
        reading: &Reading,
    ) -> Result<Self, Unread> {
        let features = features(text, reading)?;
        let mut layer = Self::default();
        let (mut has_depth, mut placeless) = (false, 0);
        for (index, feature) in features.iter().enumerate() {
            if index % AT_ONCE == 0 {
                reading.check_time()?;
            }
            if filter.is_some_and(|f| !passes(feature, f)) {
                layer.filtered_out += 1;
                continue;
            }
            let geometries = Geometries::of(feature);
            placeless += usize::from(
                geometries.polygons.is_empty() && geometries.lines.iter().all(|line| line.is_empty()),
            );
            let class = class((kind, unit), feature.properties.as_ref(), index, &mut has_depth)?;
            let called = Called::feature(class.word(), feature.properties.as_ref(), class.depth_m());
            for polygon in geometries.polygons {
                let rings = rings(polygon, index, reading)?;
                layer.areas.push(Area { class, called: called.clone(), rings, feature: index });
            }
            let sounding = matches!(class, Class::Depth { .. });
            let class = of_mark(class);
            for line in geometries.lines {
                let positions = positions(line, || format!("feature {index}"))?;
                let (called, radius_m) = (called.clone(), DANGER_M);
                layer.marks.push(Mark { class, called, sounding, positions, radius_m, feature: index });
            }
        }
        layer.check(kind, features.len(), has_depth, placeless)?;
        Ok(layer)
    }

    /// The layer with dangers of radius `radius_m` around its points and lines.
    #[must_use]
    pub fn with_danger(mut self, radius_m: f64) -> Self {
        self.marks.iter_mut().for_each(|mark| mark.radius_m = radius_m);
        self
    }

    fn check(&self, kind: &LayerKind, features: usize, named: bool, placeless: usize) -> Result<(), Invalid> {
        if placeless > 0 {
            let counted = format!("{placeless} of {features} features without a geometry");
            let remedy = "leave them out with `only`, or export the file again";
            return Err(Invalid::new("layer", counted, "a geometry for every feature", remedy));
        }
        if self.areas.is_empty() && self.marks.is_empty() {
            let counted = format!(
                "{features} features, {} filtered out, nothing charted among the rest",
                self.filtered_out
            );
            return Err(Invalid::new(
                "layer",
                counted,
                "at least one polygon, point or line",
                "check the filter and the file",
            ));
        }
        let LayerKind::Depth { least, .. } = kind else { return Ok(()) };
        if !named {
            let none = "no feature that has it";
            let expected = "the least depth in metres";
            return Err(Invalid::new(
                format!("property `{least}`"),
                none,
                expected,
                "name the property of the file",
            ));
        }
        self.check_sign(least)
    }

    fn check_sign(&self, least: &str) -> Result<(), Invalid> {
        let known = self.areas.iter().filter_map(|a| match a.class {
            Class::Depth { least_m } => least_m,
            _ => None,
        });
        let (min, max) = known.fold((f64::MAX, f64::MIN), |(lo, hi), v| (lo.min(v), hi.max(v)));
        if max >= 0.0 || min > max {
            return Ok(());
        }
        Err(Invalid::new(
            format!("property `{least}`"),
            format!("{min}..{max} m, all above the water"),
            "depths positive down",
            "reverse the sign of the property",
        ))
    }
}

pub(crate) fn features(text: &str, reading: &Reading) -> Result<Vec<Feature>, Unread> {
    let watched = Watched { rest: text.as_bytes(), reading };
    let read: Result<GeoJson, _> = serde_json::from_reader(BufReader::with_capacity(AT_ONCE_BYTES, watched));
    let geojson = match read {
        Ok(geojson) => geojson,
        Err(e) if e.is_io() => return Err(Unread::OutOfTime),
        Err(e) => {
            let expected = "a whole FeatureCollection";
            let remedy = "export or download the file again";
            return Err(Invalid::new("GeoJSON", plain(&e.to_string()), expected, remedy).into());
        }
    };
    let (features, members) = match geojson {
        GeoJson::FeatureCollection(c) => (c.features, c.foreign_members),
        GeoJson::Feature(f) => {
            let members = f.foreign_members.clone();
            (vec![f], members)
        }
        GeoJson::Geometry(g) => (vec![Feature::from(g)], None),
    };
    check_member(members.as_ref())?;
    Ok(features)
}

/// A text that ends with an error when the time limit is reached.
struct Watched<'a> {
    rest: &'a [u8],
    reading: &'a Reading<'a>,
}

impl Read for Watched<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
        self.reading.check_time().map_err(std::io::Error::other)?;
        self.rest.read(buffer)
    }
}

/// A message about GeoJSON without its expected value, which is in terms of the programming language.
fn plain(message: &str) -> String {
    let message = message.trim_start_matches("Error while deserializing GeoJSON: ");
    let (problem, rest) = message.split_once(", expected ").unwrap_or((message, ""));
    let place = rest.rfind(" at line ").map_or("", |at| &rest[at..]);
    format!("{problem}{place}")
}

fn passes(feature: &Feature, filter: &Filter) -> bool {
    let value = feature.properties.as_ref().and_then(|p| p.get(&filter.property));
    let text = match value {
        Some(JsonValue::String(s)) => s.clone(),
        Some(v) => v.to_string(),
        None => return false,
    };
    filter.values.contains(&text)
}

pub(crate) fn rings(
    polygon: &PolygonType,
    feature: usize,
    reading: &Reading,
) -> Result<Vec<Vec<[f64; 2]>>, Unread> {
    let mut rings = Vec::with_capacity(polygon.len());
    for (k, ring) in polygon.iter().enumerate() {
        rings.push(positions(ring, || format!("feature {feature}, ring {k}"))?);
    }
    match ring_fault_while(&rings, reading.keep_going) {
        Some(None) => Ok(rings),
        Some(Some(fault)) => Err(faulty(&format!("feature {feature}"), &fault).into()),
        None => Err(Unread::OutOfTime),
    }
}

/// Longitudes and latitudes; messages name them `thing`.
pub(crate) fn positions(all: &[Position], thing: impl Fn() -> String) -> Result<Vec<[f64; 2]>, Invalid> {
    let mut points = Vec::with_capacity(all.len());
    for position in all {
        let [lon, lat, ..] = *position.as_slice() else {
            let short = "a position of fewer than two numbers";
            return Err(Invalid::new(thing(), short, "longitude and latitude", "export the file again"));
        };
        if !(lon.abs() <= 180.0 && lat.abs() <= 90.0) {
            return Err(mixed(thing(), format!("{lon}, {lat}")));
        }
        points.push([lon, lat]);
    }
    Ok(points)
}

/// The refusal of rings, which messages name `named`.
pub(crate) fn faulty(named: &str, fault: &RingFault) -> Invalid {
    let (ring, problem, expected) = match fault {
        RingFault::Empty { ring } => {
            (ring, "an empty polygon".to_owned(), "at least three corners, with area")
        }
        RingFault::Open { ring } => (ring, "an open ring".to_owned(), "a last position equal to the first"),
        RingFault::NotFinite { ring } => (ring, "NaN or infinity".to_owned(), "finite coordinates"),
        RingFault::Crossing { one, other, near } => {
            let problem = format!(
                "edge {} crosses edge {} of ring {} near {}, {}",
                one.1, other.1, other.0, near[0], near[1]
            );
            (&one.0, problem, "rings that do not cross themselves or each other")
        }
    };
    Invalid::new(
        format!("{named}, ring {ring}"),
        problem,
        expected,
        "repair the polygon, for instance with `ogr2ogr -makevalid`, or remove it",
    )
}

fn class(
    (kind, unit): (&LayerKind, DepthUnit),
    properties: Option<&JsonObject>,
    index: usize,
    named: &mut bool,
) -> Result<Class, Invalid> {
    let value = |name: &String| properties.and_then(|p| p.get(name));
    let least = match kind {
        LayerKind::Land => return Ok(Class::Land),
        LayerKind::NoGo => return Ok(Class::NoGo),
        LayerKind::Danger { least } => {
            return Ok(Class::Danger { least_m: depth((value(least), unit), index, least)? });
        }
        LayerKind::Depth { least } => least,
    };
    *named |= value(least).is_some();
    Ok(Class::Depth { least_m: depth((value(least), unit), index, least)? })
}

/// A point or line has a depth and charts no water around it.
pub(crate) fn of_mark(class: Class) -> Class {
    match class {
        Class::Depth { least_m } => Class::Danger { least_m },
        class => class,
    }
}

/// A depth, which some exports write as text; null and empty are unknown.
fn depth(
    (value, unit): (Option<&JsonValue>, DepthUnit),
    feature: usize,
    name: &str,
) -> Result<Option<f64>, Invalid> {
    let number = match value {
        None | Some(JsonValue::Null) => return Ok(None),
        Some(JsonValue::String(s)) if s.trim().is_empty() => return Ok(None),
        Some(JsonValue::String(s)) => s.trim().parse().ok(),
        Some(v) => v.as_f64(),
    };
    match number.map(|v: f64| v * unit.metres()).filter(|v| v.abs() <= FARTHEST) {
        Some(v) => Ok(Some(v)),
        None => Err(Invalid::new(
            format!("feature {feature}, property `{name}`"),
            value.map(|value| refusal::foreign(&value.to_string())).unwrap_or_default(),
            format!("a depth of at most {FARTHEST} m, or null"),
            "correct it (null where it is unknown) or name another property",
        )),
    }
}

/// The parts of a feature; a point is a line of one position.
#[derive(Default)]
pub(crate) struct Geometries<'a> {
    pub polygons: Vec<&'a PolygonType>,
    pub lines: Vec<&'a [Position]>,
}

impl<'a> Geometries<'a> {
    pub(crate) fn of(feature: &'a Feature) -> Self {
        let mut geometries = Self::default();
        feature.geometry.iter().for_each(|geometry| geometries.take(&geometry.value));
        geometries
    }

    fn take(&mut self, value: &'a GeometryValue) {
        match value {
            GeometryValue::Point { coordinates } => self.lines.push(std::slice::from_ref(coordinates)),
            GeometryValue::MultiPoint { coordinates } => self.lines.extend(coordinates.chunks(1)),
            GeometryValue::LineString { coordinates } => self.lines.push(coordinates),
            GeometryValue::MultiLineString { coordinates } => {
                self.lines.extend(coordinates.iter().map(Vec::as_slice))
            }
            GeometryValue::Polygon { coordinates } => self.polygons.push(coordinates),
            GeometryValue::MultiPolygon { coordinates } => self.polygons.extend(coordinates),
            GeometryValue::GeometryCollection { geometries } => {
                geometries.iter().for_each(|geometry| self.take(&geometry.value));
            }
        }
    }
}

// The CRS of a GeoJSON file: RFC 7946 has none but WGS84, and older files name equivalent ones.

/// Refuses a member `crs` unless its coordinates are longitudes and latitudes within a metre or two of WGS84.
fn check_member(members: Option<&JsonObject>) -> Result<(), Invalid> {
    let Some(crs) = members.and_then(|m| m.get("crs")).filter(|c| !c.is_null()) else { return Ok(()) };
    let name = crs.pointer("/properties/name").and_then(JsonValue::as_str).map(str::to_owned);
    // The draft of 2008 has an EPSG code.
    let code =
        || crs.pointer("/properties/code").map(|code| format!("EPSG:{}", code.to_string().replace('"', "")));
    let is_near = |name: String| Crs::new(&name).is_ok_and(|crs| crs.is_near_wgs84());
    if name.or_else(code).is_some_and(is_near) {
        return Ok(());
    }
    Err(mixed("`crs` member", format!("`{}`", refusal::foreign(&crs.to_string()))))
}

/// The refusal of coordinates in another system than the layer's.
fn mixed(thing: impl Into<String>, found: impl Into<String>) -> Invalid {
    Invalid::new(
        thing,
        format!("{} (projected coordinates in a WGS84 layer: mixed CRS)", found.into()),
        "longitude within ±180 and latitude within ±90, WGS84",
        "transform the file, for instance with `ogr2ogr -t_srs EPSG:4326`",
    )
}
