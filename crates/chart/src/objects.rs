//! Objects of an electronic chart as polygons, points and lines of a layer, by the rules of their classes.

use std::collections::BTreeMap;

use geojson::{Feature as GeojsonFeature, JsonObject, JsonValue, Position};

use crate::classes::{Called, is, judged};
use crate::enc::{
    ALL, Attribute, DRVAL1, DUNITS, Feature, Geometry, HORDAT, HUNITS, Polygon, VALDCO, VALSOU, WATLEV,
    class as class_code, class_name,
};
use crate::grid::FARTHEST;
use crate::polygons::{Geometries, features, of_mark, positions, rings};
use crate::ring::ring_fault;
use crate::rules::Land;
use crate::traffic::label;
use crate::{
    Area, Class, Contour, DANGER_M, Ignored, Invalid, Judged, Mark, Noted, PolygonLayer, Reading, Rules,
    Traffic, Treatment, Unread,
};

/// The treatment of the objects of one class.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Tally {
    /// Objects of the class.
    pub objects: u64,
    /// Avoided, or judged by their depth.
    pub avoided: u64,
    /// Avoided by informative maneuvers only.
    pub maneuvers_avoid: u64,
    /// Without effect.
    pub ignored: u64,
    /// Why these have no effect.
    pub reasons: BTreeMap<Ignored, u64>,
}

/// The treatment of a chart's objects, by the acronym (or code) of their class.
pub type Tallies = BTreeMap<String, Tally>;

impl PolygonLayer {
    /// The layer of a chart's objects, compiled at 1 to `scale` if known, and their treatment.
    ///
    /// # Errors
    /// Rules for an unknown class; a relevant object without a geometry; depths and clearances that are not
    /// numbers, or that no sea has; parts of the chart in other units than metres, or of another datum than
    /// WGS84; rings that cross themselves or each other; no relevant object.
    pub fn from_objects(
        objects: &[Feature],
        scale: Option<u32>,
        rules: &Rules,
    ) -> Result<(Self, Tallies), Invalid> {
        rules.check()?;
        let mut layer = Self::default();
        let mut tallies = Tallies::new();
        let land = Land::of(objects);
        for (index, object) in objects.iter().enumerate() {
            check_units(object)?;
            let name = class_name(object.class).map_or_else(|| object.class.to_string(), str::to_owned);
            let tally = tallies.entry(name).or_default();
            tally.objects += 1;
            let (treatment, why) = rules.treatment(object, &land)?;
            let radius_m = rules.radius_m(object, scale);
            // The crew has to know about some objects without effect, too.
            if treatment != Treatment::Avoid && (treatment, why) != (Treatment::Ignore, Ignored::Rule) {
                layer.noted.extend(noted(object, index, radius_m.max(DANGER_M))?);
            }
            let treatment = layer.take(object, index, treatment, radius_m)?;
            match treatment {
                Treatment::Avoid => tally.avoided += 1,
                Treatment::ManeuversAvoid => tally.maneuvers_avoid += 1,
                Treatment::Ignore => {
                    tally.ignored += 1;
                    *tally.reasons.entry(why).or_default() += 1;
                }
            }
        }
        if layer.areas.is_empty() && layer.marks.is_empty() {
            let counted = format!("{} objects, none of a class that matters", objects.len());
            let expected = "depths, land or dangers";
            return Err(Invalid::new("chart", counted, expected, "name another cell, or change its `rules`"));
        }
        Ok((layer, tallies))
    }

    /// Adds the areas that an object blocks, and returns its treatment.
    fn take(
        &mut self,
        object: &Feature,
        index: usize,
        treatment: Treatment,
        radius_m: f64,
    ) -> Result<Treatment, Invalid> {
        if let (Judged::Contour, Geometry::Lines(lines)) = (judged(object.class), &object.geometry) {
            let depth_m = object.number(VALDCO)?;
            self.contours.extend(lines.iter().map(|line| Contour { depth_m, line: line.clone() }));
        }
        let Some(class) = class(object, treatment)? else { return Ok(Treatment::Ignore) };
        let called = Called::object(object, class.depth_m());
        let sounding = matches!(object.geometry, Geometry::Soundings(_));
        let mark = |class: Class, positions: Vec<[f64; 2]>| {
            let called = if sounding { Called::object(object, class.depth_m()) } else { called.clone() };
            Mark { class, called, sounding, positions, radius_m, feature: index }
        };
        match &object.geometry {
            Geometry::None => {
                let remedy = "take the cell with all its updates, or ignore the class by `rules`";
                return Err(Invalid::new(
                    object.named(),
                    "no geometry",
                    "a geometry for every relevant object",
                    remedy,
                ));
            }
            Geometry::Points(points) => {
                self.marks.extend(points.iter().map(|point| mark(of_mark(class), vec![*point])));
            }
            Geometry::Soundings(points) => {
                for [lon, lat, depth] in points {
                    let class = Class::Danger { least_m: Some(sea_depth(object, *depth)?) };
                    self.marks.push(mark(class, vec![[*lon, *lat]]));
                }
            }
            Geometry::Lines(lines) => {
                self.marks.extend(lines.iter().map(|line| mark(of_mark(class), line.clone())));
            }
            Geometry::Area(polygons) => {
                for rings in polygons {
                    check_rings(object, rings)?;
                    self.areas.push(Area {
                        class,
                        called: called.clone(),
                        rings: rings.clone(),
                        feature: index,
                    });
                }
            }
        }
        Ok(treatment)
    }
}

/// An object that the crew has to know about, its points and lines with a radius \[m\]; `None` for another one.
fn noted(object: &Feature, index: usize, radius_m: f64) -> Result<Option<Noted>, Invalid> {
    let traffic = Traffic::of(object)?;
    let Some(called) = label(object).or_else(|| traffic.map(|_| Called::object(object, None))) else {
        return Ok(None);
    };
    let class = Class::TransitOnly;
    let area = |rings: &Polygon| {
        check_rings(object, rings)?;
        Ok(Area { class, called: called.clone(), rings: rings.clone(), feature: index })
    };
    let mark = |positions: Vec<[f64; 2]>| Mark {
        class,
        called: called.clone(),
        sounding: false,
        positions,
        radius_m,
        feature: index,
    };
    let (areas, marks) = match &object.geometry {
        Geometry::Area(polygons) => (polygons.iter().map(area).collect::<Result<_, Invalid>>()?, Vec::new()),
        Geometry::Lines(lines) => (Vec::new(), lines.iter().cloned().map(mark).collect()),
        Geometry::Points(points) => (Vec::new(), points.iter().map(|point| mark(vec![*point])).collect()),
        Geometry::None | Geometry::Soundings(_) => return Ok(None),
    };
    Ok(Some(Noted { traffic, areas, marks }))
}

/// The class of an object on the chart; `None` for one without effect.
fn class(object: &Feature, treatment: Treatment) -> Result<Option<Class>, Invalid> {
    let depth = |attribute| {
        let value = object.number(attribute)?;
        value.map(|depth| sea_depth(object, depth)).transpose()
    };
    Ok(match (treatment, judged(object.class)) {
        (Treatment::Ignore, _) | (_, Judged::Coverage) => None,
        (_, Judged::Depth) => Some(Class::Depth { least_m: depth(DRVAL1)? }),
        (_, Judged::Sounding) => Some(Class::Danger { least_m: None }),
        (_, Judged::Contour) => Some(Class::Danger { least_m: depth(VALDCO)? }),
        (_, Judged::Danger) => {
            Some(Class::Danger { least_m: depth(VALSOU)?.filter(|_| is_under_water(object)) })
        }
        (Treatment::ManeuversAvoid, _) => Some(Class::TransitOnly),
        (Treatment::Avoid, Judged::Land | Judged::Body) => Some(Class::Land),
        (Treatment::Avoid, Judged::Place | Judged::Clearance | Judged::Unknown) => Some(Class::NoGo),
    })
}

/// Whether a depth over an object means that there is water over it: it does not if the object is dry or afloat.
fn is_under_water(object: &Feature) -> bool {
    let level = object.list(WATLEV);
    ![1, 2, 7].iter().any(|dry| level.contains(dry))
}

fn sea_depth(object: &Feature, depth_m: f64) -> Result<f64, Invalid> {
    if depth_m.abs() <= FARTHEST {
        return Ok(depth_m);
    }
    let expected = format!("a depth of at most {FARTHEST} m");
    Err(Invalid::new(object.named(), format!("{depth_m} m"), expected, "report it to the chart's producer"))
}

/// Parts of a chart in other units or of another datum than the rest.
const UNITS: [(&str, Attribute, f64, &str); 3] = [
    ("M_UNIT", DUNITS, 1.0, "1, depths in metres"),
    ("M_UNIT", HUNITS, 1.0, "1, heights in metres"),
    ("M_HDAT", HORDAT, 2.0, "2, WGS84"),
];

fn check_units(object: &Feature) -> Result<(), Invalid> {
    for (class, attribute, usual, expected) in UNITS {
        let value = if is(object.class, class) { object.number(attribute)? } else { None };
        if let Some(value) = value.filter(|value| *value != usual) {
            let thing = format!("{}, `{}`", object.named(), attribute.1);
            let remedy = "take the cell of the ENC product, which has metres and WGS84 throughout";
            return Err(Invalid::new(thing, value.to_string(), expected, remedy));
        }
    }
    Ok(())
}

fn check_rings(object: &Feature, rings: &Polygon) -> Result<(), Invalid> {
    ring_fault(rings).map_or(Ok(()), |fault| Err(crate::polygons::faulty(&object.named(), &fault)))
}

/// The objects of a GeoJSON file. Such files do not contain the quality of positions.
///
/// # Errors
/// Corrupt JSON; coordinates other than WGS84; a feature without the code of its class; rings that are open or cross.
pub fn objects_of_geojson(text: &str) -> Result<Vec<Feature>, Invalid> {
    read_objects(text, &Reading::whole()).map_err(Unread::into_invalid)
}

/// [`objects_of_geojson`] under a time limit.
///
/// # Errors
/// As [`objects_of_geojson`]; the end of the time limit.
pub fn read_objects(text: &str, reading: &Reading) -> Result<Vec<Feature>, Unread> {
    let features = features(text, reading)?;
    let objects = features.iter().enumerate().map(|(index, feature)| {
        reading.check_time()?;
        object(feature, index, reading)
    });
    objects.collect()
}

fn object(feature: &GeojsonFeature, index: usize, reading: &Reading) -> Result<Feature, Unread> {
    let properties = feature.properties.as_ref();
    let value =
        |name: &str| properties.and_then(|properties| properties.get(name)).filter(|value| !value.is_null());
    let code = value("OBJL").and_then(text).and_then(|code| code.parse().ok());
    let Some(code) = code else {
        return Err(Invalid::new(
            format!("feature {index}, property `OBJL`"),
            value("OBJL").map_or("none".to_owned(), JsonValue::to_string),
            "the code of its object class, as GDAL writes it",
            "convert the cell again by `ogr2ogr`, or name a `kind` for the whole file",
        )
        .into());
    };
    let attributes = ALL.iter().filter_map(|(code, name)| Some((*code, text(value(name)?)?))).collect();
    let mut object = Feature {
        class: code,
        id: id(properties, index),
        attributes,
        geometry: Geometry::None,
        position_quality: Vec::new(),
    };
    object.geometry = geometry(feature, index, Some(code) == class_code("SOUNDG"), reading)?;
    Ok(object)
}

fn id(properties: Option<&JsonObject>, index: usize) -> String {
    let part = |name: &str| properties.and_then(|properties| properties.get(name)).and_then(text);
    match (part("AGEN"), part("FIDN"), part("FIDS")) {
        (Some(producer), Some(number), Some(subdivision)) => format!("{producer}-{number}-{subdivision}"),
        _ => format!("feature {index}"),
    }
}

/// A value as S-57 writes it; lists with commas.
fn text(value: &JsonValue) -> Option<String> {
    match value {
        JsonValue::String(text) => Some(text.clone()),
        JsonValue::Number(number) => Some(number.to_string()),
        JsonValue::Array(values) => {
            values.iter().map(text).collect::<Option<Vec<_>>>().map(|all| all.join(","))
        }
        _ => None,
    }
}

fn geometry(
    feature: &GeojsonFeature,
    index: usize,
    soundings: bool,
    reading: &Reading,
) -> Result<Geometry, Unread> {
    let geometries = Geometries::of(feature);
    let named = || format!("feature {index}");
    if !geometries.polygons.is_empty() {
        let polygons = geometries.polygons.into_iter().map(|polygon| rings(polygon, index, reading));
        return Ok(Geometry::Area(polygons.collect::<Result<_, _>>()?));
    }
    if soundings {
        let all = geometries.lines.iter().flat_map(|line| line.iter());
        return Ok(Geometry::Soundings(all.map(|p| sounding(p, index)).collect::<Result<_, Invalid>>()?));
    }
    let lines =
        geometries.lines.into_iter().map(|line| positions(line, named)).collect::<Result<Vec<_>, _>>()?;
    if lines.iter().all(|line| line.len() < 2) {
        let points: Vec<[f64; 2]> = lines.concat();
        return Ok(if points.is_empty() { Geometry::None } else { Geometry::Points(points) });
    }
    Ok(Geometry::Lines(lines))
}

fn sounding(position: &Position, index: usize) -> Result<[f64; 3], Invalid> {
    let place = positions(std::slice::from_ref(position), || format!("feature {index}"))?[0];
    match position.as_slice().get(2) {
        Some(depth) => Ok([place[0], place[1], *depth]),
        None => Err(Invalid::new(
            format!("feature {index}"),
            "a sounding without a depth",
            "longitude, latitude, depth",
            "convert the cell again by `ogr2ogr`, with three dimensions",
        )),
    }
}
