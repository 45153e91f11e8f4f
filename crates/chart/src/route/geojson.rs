use geojson::{FeatureCollection, GeometryValue, JsonObject, Position};

use super::points::rounded;
use crate::Invalid;

/// A feature: geometry and properties.
#[derive(Clone, Debug, PartialEq)]
pub struct Feature {
    /// Its geometry.
    pub geometry: Geometry,
    /// Any JSON object, such as the step, the maneuver and the time.
    pub properties: JsonObject,
}

impl Feature {
    /// A feature with the entries of `properties`; without any where that is no object.
    pub fn new(geometry: Geometry, properties: serde_json::Value) -> Self {
        let properties =
            if let serde_json::Value::Object(own) = properties { own } else { JsonObject::new() };
        Self { geometry, properties }
    }
}

/// A geometry of (longitude, latitude) \[deg\].
#[derive(Clone, Debug, PartialEq)]
pub enum Geometry {
    /// A position: start, goal.
    Point([f64; 2]),
    /// A track of at least two points.
    Line(Vec<[f64; 2]>),
}

/// The features as a GeoJSON FeatureCollection (RFC 7946), in order: longitude first, to 10⁻⁹ degrees. Lines
/// are cut at the antimeridian, as the RFC requires.
///
/// # Errors
/// Coordinates that are not finite or out of range; a line of fewer than two points.
pub fn geojson(features: &[Feature]) -> Result<String, Invalid> {
    let feature = |(index, f): (usize, &Feature)| {
        let geometry = geometry(&f.geometry, &format!("feature {index}"))?;
        Ok(geojson::Feature {
            geometry: Some(geojson::Geometry::new(geometry)),
            properties: Some(f.properties.clone()),
            ..geojson::Feature::default()
        })
    };
    let features = features.iter().enumerate().map(feature).collect::<Result<Vec<_>, Invalid>>()?;
    let collection = FeatureCollection { bbox: None, features, foreign_members: None };
    serde_json::to_string(&collection).map(|text| text + "\n").map_err(|e| {
        Invalid::new("GeoJSON", e.to_string(), "properties that JSON can hold", "report this as a defect")
    })
}

fn geometry(geometry: &Geometry, thing: &str) -> Result<GeometryValue, Invalid> {
    match geometry {
        Geometry::Point(p) => Ok(GeometryValue::Point { coordinates: positions(&[*p], 1, thing)?.remove(0) }),
        Geometry::Line(line) => self::line(line, thing),
    }
}

fn line(line: &[[f64; 2]], thing: &str) -> Result<GeometryValue, Invalid> {
    let (mut parts, mut part) = (Vec::new(), Vec::new());
    for (index, place) in line.iter().enumerate() {
        let before = index.checked_sub(1).map(|before| line[before]);
        if let Some([end, begin]) = before.and_then(|before| at_antimeridian(before, *place)) {
            part.push(end);
            parts.push(std::mem::replace(&mut part, vec![begin]));
        }
        part.push(*place);
    }
    parts.push(part);
    let parts = parts.iter().map(|part| positions(part, 2, thing)).collect::<Result<Vec<_>, _>>()?;
    Ok(match <[_; 1]>::try_from(parts) {
        Ok([coordinates]) => GeometryValue::LineString { coordinates },
        Err(coordinates) => GeometryValue::MultiLineString { coordinates },
    })
}

/// Where a step crosses the antimeridian, on its own side and on the other; `None` if it does not.
fn at_antimeridian(from: [f64; 2], to: [f64; 2]) -> Option<[[f64; 2]; 2]> {
    if (to[0] - from[0]).abs() <= 180.0 {
        return None;
    }
    let edge = 180_f64.copysign(from[0]);
    let step = to[0] + 2.0 * edge - from[0];
    let part = if step == 0.0 { 0.0 } else { (edge - from[0]) / step };
    let latitude = from[1] + part * (to[1] - from[1]);
    Some([[edge, latitude], [-edge, latitude]])
}

fn positions(points: &[[f64; 2]], least: usize, thing: &str) -> Result<Vec<Position>, Invalid> {
    Ok(rounded(points, least, thing)?.into_iter().map(Position::from).collect())
}
