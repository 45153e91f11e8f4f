use std::io;

use super::points::NAUTICAL_MILE_M;
use super::time::Instant;
use super::xml::{Xml, decimal, document, latitude, longitude};
use super::{Route, Waypoint};
use crate::Invalid;

const NAMESPACE: &str = "http://www.cirm.org/RTZ/1/0";
const KNOT_M_S: f64 = NAUTICAL_MILE_M / 3600.0;
/// Radii and corridors must be below this.
const LARGEST_NM: f64 = 10.0;

/// The route as RTZ 1.0 (IEC 61174:2015, annex S): nautical miles and knots.
///
/// A leg belongs to the waypoint where it ends, so the first waypoint has none; legs are loxodromes. With a
/// departure and times there is one schedule of the arrivals, under the element name `sheduleElement` that
/// version 1.0 has.
///
/// # Errors
/// Fewer than two waypoints; an id twice; coordinates, speeds, radii or corridors that are not finite or
/// out of range; a radius of at least half the shortest adjacent leg or of 10 NM; times that run backwards;
/// names with control characters; a departure that is no time.
pub fn rtz(route: &Route) -> Result<String, Invalid> {
    route.check()?;
    check_miles(route)?;
    let departure = route.departure()?;
    document(|xml| {
        let root = xml.create_element("route").with_attributes([("xmlns", NAMESPACE), ("version", "1.0")]);
        root.write_inner_content(|xml| {
            xml.create_element("routeInfo")
                .with_attribute(("routeName", route.name.as_str()))
                .write_empty()?;
            xml.create_element("waypoints").write_inner_content(|xml| waypoints(xml, route))?;
            match departure {
                Some(departure) if route.waypoints.iter().any(|w| w.t_s.is_some()) => {
                    schedule(xml, route, departure)
                }
                _ => Ok(()),
            }
        })?;
        Ok(())
    })
}

fn check_miles(route: &Route) -> Result<(), Invalid> {
    for (index, waypoint) in route.waypoints.iter().enumerate() {
        let radius = waypoint.turn_radius_m.filter(|_| route.is_inner(index));
        for (name, value) in [("turn radius", radius), ("corridor", waypoint.corridor_m)] {
            if let Some(metres) = value.filter(|m| m / NAUTICAL_MILE_M >= LARGEST_NM - 1e-6) {
                return Err(Invalid::new(
                    format!("waypoint {}, {name}", waypoint.id),
                    format!("{metres} m"),
                    "below 10 NM, as RTZ asks",
                    "lower it",
                ));
            }
        }
    }
    Ok(())
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

/// The leg that ends at a waypoint.
fn leg(xml: &mut Xml, waypoint: &Waypoint) -> io::Result<()> {
    let corridor = waypoint.corridor_m.map(|m| decimal(m / NAUTICAL_MILE_M, 6));
    let speed = waypoint.speed_m_s.map(|v| decimal(v / KNOT_M_S, 6));
    let mut element = xml.create_element("leg");
    if let Some(corridor) = &corridor {
        let sides = [("starboardXTD", corridor.as_str()), ("portsideXTD", corridor.as_str())];
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

fn schedule(xml: &mut Xml, route: &Route, departure: Instant) -> io::Result<()> {
    let first = route.waypoints.first().map(|w| w.id);
    let element = |xml: &mut Xml, waypoint: &Waypoint, t_s: f64| {
        let id = waypoint.id.to_string();
        let time = departure.after(t_s);
        let key = if Some(waypoint.id) == first { "etd" } else { "eta" };
        let attributes = [("waypointId", id.as_str()), (key, time.as_str())];
        xml.create_element("sheduleElement").with_attributes(attributes).write_empty().map(|_| ())
    };
    let schedules = xml.create_element("schedules");
    schedules.write_inner_content(|xml| {
        let schedule = xml.create_element("schedule").with_attribute(("id", "1"));
        schedule.write_inner_content(|xml| {
            xml.create_element("manual").write_inner_content(|xml| {
                let timed = route.waypoints.iter().filter_map(|w| w.t_s.map(|t| (w, t)));
                timed.into_iter().try_for_each(|(w, t)| element(xml, w, t))
            })?;
            Ok(())
        })?;
        Ok(())
    })?;
    Ok(())
}
