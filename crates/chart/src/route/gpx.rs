use std::io;

use jiff::Timestamp;
use quick_xml::writer::ElementWriter;

use super::points::{KNOT_M_S, instant};
use super::xml::{Xml, document, element, latitude, longitude};
use super::{Route, Track};
use crate::Invalid;

const NAMESPACE: &str = "http://www.topografix.com/GPX/1/1";

/// The route and tracks as GPX 1.1: one `rte`, then a `trk` of one segment per track.
///
/// # Errors
/// As [`super::rtz`], but for the limit of 10 NM; a track point that is out of range.
pub fn gpx(route: &Route, tracks: &[Track]) -> Result<String, Invalid> {
    route.check()?;
    tracks.iter().try_for_each(Track::check)?;
    document(|xml| {
        let attributes = [("version", "1.1"), ("creator", "seatrial"), ("xmlns", NAMESPACE)];
        let root = xml.create_element("gpx").with_attributes(attributes);
        root.write_inner_content(|xml| {
            xml.create_element("rte").write_inner_content(|xml| {
                element(xml, "name", &route.name)?;
                (0..route.waypoints.len()).try_for_each(|index| route_point(xml, route, index))
            })?;
            tracks.iter().try_for_each(|t| track(xml, t, route.departure))
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
                let own = point(xml, "trkpt", *place);
                match time(index) {
                    Some(time) => own.write_inner_content(|xml| element(xml, "time", &time))?,
                    None => own.write_empty()?,
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
        if waypoint.note.is_empty() { Ok(()) } else { element(xml, "desc", &waypoint.note) }
    });
    written.map(|_| ())
}

/// An element with a position.
fn point<'a>(xml: &'a mut Xml, name: &'a str, [lon_deg, lat_deg]: [f64; 2]) -> ElementWriter<'a, Vec<u8>> {
    let (lat, lon) = (latitude(lat_deg), longitude(lon_deg));
    xml.create_element(name).with_attributes([("lat", lat.as_str()), ("lon", lon.as_str())])
}
