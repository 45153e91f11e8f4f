use std::io;

use jiff::Timestamp;
use quick_xml::Writer;
use quick_xml::events::{BytesDecl, BytesText, Event};
use quick_xml::writer::ElementWriter;
use refusal::check_numbers;
use serde_json::{Value, json};

use super::{KNOT_M_S, NAUTICAL_MILE_M, Route, Track, Waypoint, instant, rounded};
use crate::Invalid;
use geojson::{FeatureCollection, GeometryValue, JsonObject, Position};

const NAMESPACE: &str = "http://www.cirm.org/RTZ/1/0";
/// Upper limit of radii and cross-track distances.
const LARGEST_NM: f64 = 10.0;

/// The route as RTZ 1.0 (IEC 61174:2015, annex S): nautical miles and knots.
///
/// A leg belongs to the waypoint where it ends, so the first waypoint has none; legs are loxodromes.
///
/// # Errors
/// Fewer than two waypoints; an id twice; coordinates, speeds or radii that are not finite or out of range; a radius of
/// at least half the shortest adjacent leg or of 10 NM; names with control characters.
pub fn rtz(route: &Route) -> Result<String, Invalid> {
    route.check()?;
    check_miles(route)?;
    document(|xml| {
        let root = xml.create_element("route").with_attributes([("xmlns", NAMESPACE), ("version", "1.0")]);
        root.write_inner_content(|xml| {
            xml.create_element("routeInfo")
                .with_attribute(("routeName", route.name.as_str()))
                .write_empty()?;
            xml.create_element("waypoints").write_inner_content(|xml| waypoints(xml, route))?;
            if route.instant(0).is_some() { schedule(xml, route) } else { Ok(()) }
        })?;
        Ok(())
    })
}

fn check_miles(route: &Route) -> Result<(), Invalid> {
    let inner = route.waypoints.iter().enumerate().filter(|(index, _)| route.is_inner(*index));
    let radii =
        inner.filter_map(|(_, w)| Some((format!("waypoint {}, turn radius", w.id), w.turn_radius_m?)));
    check_numbers(radii, "below 10 NM in metres, as RTZ asks", |m| m / NAUTICAL_MILE_M < LARGEST_NM - 1e-6)
}

fn waypoints(xml: &mut Xml, route: &Route) -> io::Result<()> {
    for (index, waypoint) in route.waypoints.iter().enumerate() {
        let id = waypoint.id.to_string();
        let radius = waypoint.turn_radius_m.filter(|_| route.is_inner(index));
        let radius = radius.map(|r| decimal(r / NAUTICAL_MILE_M, 6));
        let mut element = xml.create_element("waypoint").with_attribute(("id", id.as_str()));
        if !waypoint.name.is_empty() {
            element = element.with_attribute(("name", waypoint.name.as_str()));
        }
        if let Some(radius) = &radius {
            element = element.with_attribute(("radius", radius.as_str()));
        }
        element.write_inner_content(|xml| {
            let (lat, lon) = (latitude(waypoint.lat_deg), longitude(waypoint.lon_deg));
            let place = [("lat", lat.as_str()), ("lon", lon.as_str())];
            xml.create_element("position").with_attributes(place).write_empty()?;
            if index == 0 { Ok(()) } else { leg(xml, waypoint) }
        })?;
    }
    Ok(())
}

/// The departure as the decided time, the times that follow as calculated ones.
fn schedule(xml: &mut Xml, route: &Route) -> io::Result<()> {
    xml.create_element("schedules").write_inner_content(|xml| {
        let with_attributes =
            xml.create_element("schedule").with_attributes([("id", "1"), ("name", "planned")]);
        with_attributes.write_inner_content(|xml| {
            xml.create_element("manual").write_inner_content(|xml| scheduled(xml, route, 0))?;
            xml.create_element("calculated").write_inner_content(|xml| {
                (0..route.waypoints.len()).try_for_each(|index| scheduled(xml, route, index))
            })?;
            Ok(())
        })?;
        Ok(())
    })?;
    Ok(())
}

/// A waypoint's times: the departure from the first, the arrival at others, and the departure from those where the ship
/// stays. Version 1.0 of the schema spells the element this way.
fn scheduled(xml: &mut Xml, route: &Route, index: usize) -> io::Result<()> {
    let Some(time) = route.instant(index) else { return Ok(()) };
    let waypoint = &route.waypoints[index];
    let (id, speed) = (waypoint.id.to_string(), waypoint.speed_m_s.map(knots));
    let mut element = xml.create_element("sheduleElement").with_attribute(("waypointId", id.as_str()));
    let leave = route.leave(index);
    if index > 0 {
        element = element.with_attribute(("eta", time.as_str()));
    }
    if let Some(leave) = leave.as_deref().or_else(|| (index == 0).then_some(time.as_str())) {
        element = element.with_attribute(("etd", leave));
    }
    if let Some(speed) = speed.as_deref().filter(|_| index > 0) {
        element = element.with_attribute(("speed", speed));
    }
    element.write_empty().map(|_| ())
}

fn knots(speed_m_s: f64) -> String {
    decimal(speed_m_s / KNOT_M_S, 6)
}

/// The leg that ends at a waypoint.
fn leg(xml: &mut Xml, waypoint: &Waypoint) -> io::Result<()> {
    let speed = waypoint.speed_m_s.map(knots);
    // A corridor wider than the format allows is left out, not narrowed.
    let xtd = waypoint.xtd_m.filter(|xtd| xtd.iter().all(|m| m / NAUTICAL_MILE_M < LARGEST_NM - 1e-6));
    let xtd = xtd.map(|xtd| xtd.map(|m| decimal(m / NAUTICAL_MILE_M, 6)));
    let mut element = xml.create_element("leg");
    if let Some([port, starboard]) = &xtd {
        let sides = [("starboardXTD", starboard.as_str()), ("portsideXTD", port.as_str())];
        element = element.with_attributes(sides);
    }
    element = element.with_attribute(("geometryType", "Loxodrome"));
    if let Some(speed) = &speed {
        element = element.with_attributes([("speedMin", speed.as_str()), ("speedMax", speed.as_str())]);
    }
    if !waypoint.note.is_empty() {
        element = element.with_attribute(("legInfo", waypoint.note.as_str()));
    }
    element.write_empty().map(|_| ())
}

type Xml = Writer<Vec<u8>>;

/// A document whose elements `content` writes.
fn document(content: impl FnOnce(&mut Xml) -> io::Result<()>) -> Result<String, Invalid> {
    let failed = |found: String| Invalid::new("XML", found, "text", "report this as a defect");
    let mut writer = Writer::new_with_indent(Vec::new(), b' ', 2);
    let declaration = BytesDecl::new("1.0", Some("UTF-8"), None);
    let written = writer.write_event(Event::Decl(declaration)).and_then(|()| content(&mut writer));
    written.map_err(|e| failed(e.to_string()))?;
    let mut text = String::from_utf8(writer.into_inner()).map_err(|e| failed(e.to_string()))?;
    text.push('\n');
    Ok(text)
}

/// An element that holds text.
fn element(xml: &mut Xml, name: &str, text: &str) -> io::Result<()> {
    xml.create_element(name).write_text_content(BytesText::new(text)).map(|_| ())
}

/// A decimal number without exponent and trailing zeros.
fn decimal(value: f64, digits: usize) -> String {
    let text = format!("{value:.digits$}");
    let short = if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { &text };
    if short == "-0" { "0".to_owned() } else { short.to_owned() }
}

/// Longitude in [−180, 180) as both formats require, to 10⁻⁹ degrees.
fn longitude(lon_deg: f64) -> String {
    let text = decimal(lon_deg, 9);
    if text == "180" { "-180".to_owned() } else { text }
}

/// Latitude, to 10⁻⁹ degrees (0.1 mm).
fn latitude(lat_deg: f64) -> String {
    decimal(lat_deg, 9)
}

/// MAVLink's number for a waypoint.
const WAYPOINT: u32 = 16;
/// MAVLink's number for a change of speed.
const CHANGE_SPEED: u32 = 178;
/// The frame of waypoints: heights above home.
const ABOVE_HOME: u32 = 3;
/// The frame of commands without a position.
const NO_FRAME: u32 = 2;

/// The route as a mission of a surface vessel for QGroundControl (plan file, version 1): every waypoint with
/// the speed on the leg that ends there. Maneuvers are not included: the mission leads from one to the next.
///
/// # Errors
/// As [`super::rtz`], but for the limit of 10 NM.
pub fn qgroundcontrol(route: &Route) -> Result<String, Invalid> {
    route.check()?;
    let mut items = Vec::new();
    let mut speed = None;
    for waypoint in &route.waypoints {
        if let Some(wanted) = waypoint.speed_m_s.filter(|wanted| speed != Some(*wanted)) {
            let params = [json!(1), json!(wanted), json!(-1), json!(0), json!(0), json!(0), json!(0)];
            items.push(item(items.len(), CHANGE_SPEED, NO_FRAME, &params));
            speed = Some(wanted);
        }
        items.push(go_to(items.len(), waypoint));
    }
    let cruise = route.waypoints.iter().filter_map(|w| w.speed_m_s).fold(0.0, f64::max);
    let home = &route.waypoints[0];
    let plan = json!({
        "fileType": "Plan",
        "version": 1,
        "groundStation": "QGroundControl",
        // Not a key of the format: ground stations ignore it, users can read it.
        "description": route.name,
        "mission": {
            "version": 2,
            // ArduPilot, a surface boat.
            "firmwareType": 3,
            "vehicleType": 11,
            "cruiseSpeed": cruise,
            "hoverSpeed": cruise,
            "globalPlanAltitudeMode": 1,
            "plannedHomePosition": [home.lat_deg, home.lon_deg, 0],
            "items": items,
        },
        "geoFence": {"version": 2, "circles": [], "polygons": []},
        "rallyPoints": {"version": 2, "points": []},
    });
    Ok(format!("{plan:#}\n"))
}

fn go_to(place: usize, waypoint: &Waypoint) -> Value {
    let radius = json!(waypoint.turn_radius_m.unwrap_or(0.0));
    let (lat, lon) = (json!(waypoint.lat_deg), json!(waypoint.lon_deg));
    item(place, WAYPOINT, ABOVE_HOME, &[json!(0), radius, json!(0), Value::Null, lat, lon, json!(0)])
}

fn item(place: usize, command: u32, frame: u32, params: &[Value; 7]) -> Value {
    json!({"type": "SimpleItem", "autoContinue": true, "doJumpId": place + 1, "command": command, "frame": frame,
        "params": params})
}

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
            if let serde_json::Value::Object(entries) = properties { entries } else { JsonObject::new() };
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

const GPX_NAMESPACE: &str = "http://www.topografix.com/GPX/1/1";
/// Of the elements by which OpenCPN knows speeds and departures.
const OPENCPN: &str = "http://www.opencpn.org";

/// Routes and tracks as GPX 1.1: an `rte` per route, then a `trk` of one segment per track, which have the departure of the first
/// route.
///
/// # Errors
/// As [`super::rtz`], but for the limit of 10 NM; a track point that is out of range.
pub fn gpx(routes: &[&Route], tracks: &[Track]) -> Result<String, Invalid> {
    routes.iter().try_for_each(|route| route.check())?;
    let departure = routes.first().and_then(|route| route.departure);
    tracks.iter().try_for_each(Track::check)?;
    document(|xml| {
        let attributes = [("version", "1.1"), ("creator", "seatrial"), ("xmlns", GPX_NAMESPACE)];
        let attributes = attributes.into_iter().chain([("xmlns:opencpn", OPENCPN)]);
        let root = xml.create_element("gpx").with_attributes(attributes);
        root.write_inner_content(|xml| {
            for route in routes {
                xml.create_element("rte").write_inner_content(|xml| {
                    element(xml, "name", &route.name)?;
                    if let Some(departure) = route.instant(0) {
                        xml.create_element("extensions").write_inner_content(|xml| {
                            element(xml, "opencpn:planned_departure", &departure)
                        })?;
                    }
                    (0..route.waypoints.len()).try_for_each(|index| route_point(xml, route, index))
                })?;
            }
            tracks.iter().try_for_each(|t| track(xml, t, departure))
        })?;
        Ok(())
    })
}

fn track(xml: &mut Xml, track: &Track, departure: Option<Timestamp>) -> io::Result<()> {
    let time = |index: usize| instant(departure?, track.time_s(index));
    xml.create_element("trk").write_inner_content(|xml| {
        element(xml, "name", &track.name)?;
        xml.create_element("trkseg").write_inner_content(|xml| {
            track.points.iter().enumerate().try_for_each(|(index, place)| {
                let point = point(xml, "trkpt", *place);
                match time(index) {
                    Some(time) => point.write_inner_content(|xml| element(xml, "time", &time))?,
                    None => point.write_empty()?,
                };
                Ok(())
            })
        })?;
        Ok(())
    })?;
    Ok(())
}

fn route_point(xml: &mut Xml, route: &Route, index: usize) -> io::Result<()> {
    let waypoint = &route.waypoints[index];
    let point = point(xml, "rtept", [waypoint.lon_deg, waypoint.lat_deg]);
    let written = point.write_inner_content(|xml| {
        route.instant(index).map_or(Ok(()), |time| element(xml, "time", &time))?;
        let name = if waypoint.name.is_empty() { waypoint.id.to_string() } else { waypoint.name.clone() };
        element(xml, "name", &name)?;
        if let Some(speed) = waypoint.speed_m_s.filter(|_| index > 0) {
            element(xml, "cmt", &format!("{:.1} kn on the leg to here", speed / KNOT_M_S))?;
        }
        if !waypoint.note.is_empty() {
            element(xml, "desc", &waypoint.note)?;
        }
        by_opencpn(xml, route, index)
    });
    written.map(|_| ())
}

/// The speed of the leg that ends at a waypoint, and when the ship leaves it if she stays, as OpenCPN reads them.
fn by_opencpn(xml: &mut Xml, route: &Route, index: usize) -> io::Result<()> {
    let speed = route.waypoints[index].speed_m_s.filter(|_| index > 0).map(knots);
    let leave = route.leave(index).map(|leave| leave.trim_end_matches('Z').to_owned());
    if speed.is_none() && leave.is_none() {
        return Ok(());
    }
    let written = xml.create_element("extensions").write_inner_content(|xml| {
        let properties = [("planned_speed", &speed), ("etd", &leave)];
        let given = properties.iter().filter_map(|(name, value)| Some((*name, value.as_deref()?)));
        xml.create_element("opencpn:rte_properties").with_attributes(given).write_empty()?;
        Ok(())
    });
    written.map(|_| ())
}

/// An element with a position.
fn point<'a>(xml: &'a mut Xml, name: &'a str, [lon_deg, lat_deg]: [f64; 2]) -> ElementWriter<'a, Vec<u8>> {
    let (lat, lon) = (latitude(lat_deg), longitude(lon_deg));
    xml.create_element(name).with_attributes([("lat", lat.as_str()), ("lon", lon.as_str())])
}
