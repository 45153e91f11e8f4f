use std::io;

use refusal::check_numbers;

use super::points::{KNOT_M_S, NAUTICAL_MILE_M};
use super::xml::{Xml, decimal, document, latitude, longitude};
use super::{Route, Waypoint};
use crate::Invalid;

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

/// A waypoint's times: the departure from the first, the arrival at others, and the departure from those where the ship stays.
/// Version 1.0 of the schema spells
/// the element this way.
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
