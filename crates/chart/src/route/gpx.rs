use std::io;

use quick_xml::events::BytesText;
use quick_xml::writer::ElementWriter;

use super::xml::{Xml, document, latitude, longitude};
use super::{Route, Track, Waypoint};
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
                route.waypoints.iter().try_for_each(|w| route_point(xml, w))
            })?;
            tracks.iter().try_for_each(|t| track(xml, t))
        })?;
        Ok(())
    })
}

fn track(xml: &mut Xml, track: &Track) -> io::Result<()> {
    xml.create_element("trk").write_inner_content(|xml| {
        element(xml, "name", &track.name)?;
        xml.create_element("trkseg").write_inner_content(|xml| {
            track.points.iter().try_for_each(|p| point(xml, "trkpt", *p).write_empty().map(|_| ()))
        })?;
        Ok(())
    })?;
    Ok(())
}

fn route_point(xml: &mut Xml, waypoint: &Waypoint) -> io::Result<()> {
    let point = point(xml, "rtept", [waypoint.lon_deg, waypoint.lat_deg]);
    let written = point.write_inner_content(|xml| {
        let name = if waypoint.name.is_empty() { waypoint.id.to_string() } else { waypoint.name.clone() };
        element(xml, "name", &name)?;
        if waypoint.note.is_empty() { Ok(()) } else { element(xml, "desc", &waypoint.note) }
    });
    written.map(|_| ())
}

/// An element that stands at a place.
fn point<'a>(xml: &'a mut Xml, name: &'a str, [lon_deg, lat_deg]: [f64; 2]) -> ElementWriter<'a, Vec<u8>> {
    let (lat, lon) = (latitude(lat_deg), longitude(lon_deg));
    xml.create_element(name).with_attributes([("lat", lat.as_str()), ("lon", lon.as_str())])
}

fn element(xml: &mut Xml, name: &str, text: &str) -> io::Result<()> {
    xml.create_element(name).write_text_content(BytesText::new(text)).map(|_| ())
}
