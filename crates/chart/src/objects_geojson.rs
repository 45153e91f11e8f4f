//! Objects of an electronic chart that `ogr2ogr` wrote as GeoJSON: their class in `OBJL`, attributes by their
//! acronyms.

use crate::enc::attribute::ALL;
use crate::enc::{Feature as Object, Geometry, class};
use geojson::{Feature, JsonObject, JsonValue, Position};

use crate::geometries::Geometries;
use crate::polygons::{features, positions, rings};
use crate::{Invalid, Reading, Unread};

/// The objects of a GeoJSON file. Such files do not contain the quality of positions.
///
/// # Errors
/// Corrupt JSON; coordinates other than WGS84; a feature without the code of its class; rings that are open or cross.
pub fn objects_of_geojson(text: &str) -> Result<Vec<Object>, Invalid> {
    read_objects(text, &Reading::whole()).map_err(Unread::into_invalid)
}

/// [`objects_of_geojson`] under a time limit.
///
/// # Errors
/// As [`objects_of_geojson`]; the end of the time limit.
pub fn read_objects(text: &str, reading: &Reading) -> Result<Vec<Object>, Unread> {
    let features = features(text, reading)?;
    let objects = features.iter().enumerate().map(|(index, feature)| {
        reading.check_time()?;
        object(feature, index, reading)
    });
    objects.collect()
}

fn object(feature: &Feature, index: usize, reading: &Reading) -> Result<Object, Unread> {
    let properties = feature.properties.as_ref();
    let value = |name: &str| properties.and_then(|own| own.get(name)).filter(|value| !value.is_null());
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
    let mut own = Object {
        class: code,
        id: id(properties, index),
        attributes,
        geometry: Geometry::None,
        position_quality: Vec::new(),
    };
    own.geometry = geometry(feature, index, Some(code) == class("SOUNDG"), reading)?;
    Ok(own)
}

fn id(properties: Option<&JsonObject>, index: usize) -> String {
    let part = |name: &str| properties.and_then(|own| own.get(name)).and_then(text);
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

fn geometry(feature: &Feature, index: usize, soundings: bool, reading: &Reading) -> Result<Geometry, Unread> {
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
