use std::io;

use quick_xml::events::BytesText;

use super::time::Instant;
use super::xml::{Xml, document, latitude, longitude};
use super::{Route, Track, TrackPoint, Waypoint};
use crate::Invalid;

const NAMESPACE: &str = "http://www.topografix.com/GPX/1/1";

/// The route and tracks as GPX 1.1: one `rte`, then a `trk` of one segment per track. Times are written
/// where the route has a departure.
///
/// # Errors
/// As [`super::rtz`], but for the limit of 10 NM; a track point that is out of range.
pub fn gpx(route: &Route, tracks: &[Track]) -> Result<String, Invalid> {
    route.check()?;
    tracks.iter().try_for_each(Track::check)?;
    let departure = route.departure()?;
    document(|xml| {
        let attributes = [("version", "1.1"), ("creator", "seatrial"), ("xmlns", NAMESPACE)];
        let root = xml.create_element("gpx").with_attributes(attributes);
        root.write_inner_content(|xml| {
            xml.create_element("rte").write_inner_content(|xml| {
                element(xml, "name", &route.name)?;
                route.waypoints.iter().try_for_each(|w| route_point(xml, w, departure))
            })?;
            tracks.iter().try_for_each(|t| track(xml, t, departure))
        })?;
        Ok(())
    })
}

fn track(xml: &mut Xml, track: &Track, departure: Option<Instant>) -> io::Result<()> {
    xml.create_element("trk").write_inner_content(|xml| {
        element(xml, "name", &track.name)?;
        xml.create_element("trkseg").write_inner_content(|xml| {
            track.points.iter().try_for_each(|p| track_point(xml, p, departure))
        })?;
        Ok(())
    })?;
    Ok(())
}

fn route_point(xml: &mut Xml, waypoint: &Waypoint, departure: Option<Instant>) -> io::Result<()> {
    point(xml, "rtept", waypoint.lon_deg, waypoint.lat_deg, |xml| {
        time(xml, departure, waypoint.t_s)?;
        let name = if waypoint.name.is_empty() { waypoint.id.to_string() } else { waypoint.name.clone() };
        element(xml, "name", &name)?;
        if waypoint.note.is_empty() { Ok(()) } else { element(xml, "desc", &waypoint.note) }
    })
}

fn track_point(xml: &mut Xml, at: &TrackPoint, departure: Option<Instant>) -> io::Result<()> {
    if departure.is_some() && at.t_s.is_some() {
        return point(xml, "trkpt", at.lon_deg, at.lat_deg, |xml| time(xml, departure, at.t_s));
    }
    let (lat, lon) = (latitude(at.lat_deg), longitude(at.lon_deg));
    let place = [("lat", lat.as_str()), ("lon", lon.as_str())];
    xml.create_element("trkpt").with_attributes(place).write_empty().map(|_| ())
}

fn point(
    xml: &mut Xml,
    name: &str,
    lon_deg: f64,
    lat_deg: f64,
    content: impl FnOnce(&mut Xml) -> io::Result<()>,
) -> io::Result<()> {
    let (lat, lon) = (latitude(lat_deg), longitude(lon_deg));
    let element = xml.create_element(name).with_attributes([("lat", lat.as_str()), ("lon", lon.as_str())]);
    element.write_inner_content(content).map(|_| ())
}

fn time(xml: &mut Xml, departure: Option<Instant>, t_s: Option<f64>) -> io::Result<()> {
    match (departure, t_s) {
        (Some(departure), Some(t)) => element(xml, "time", &departure.after(t)),
        _ => Ok(()),
    }
}

fn element(xml: &mut Xml, name: &str, text: &str) -> io::Result<()> {
    xml.create_element(name).write_text_content(BytesText::new(text)).map(|_| ())
}
