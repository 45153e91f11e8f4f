use std::io;

use super::points::instant;
use super::xml::{Xml, document, element, latitude, longitude};
use super::{Route, Track};
use crate::Invalid;

const NAMESPACE: &str = "http://www.opengis.net/kml/2.2";

/// The route's waypoints and tracks as KML 2.2, clamped to the sea surface: a folder of each. With a
/// departure tracks have a time span.
///
/// # Errors
/// As [`super::gpx`].
pub fn kml(route: &Route, tracks: &[Track]) -> Result<String, Invalid> {
    route.check()?;
    tracks.iter().try_for_each(Track::check)?;
    document(|xml| {
        let root = xml.create_element("kml").with_attribute(("xmlns", NAMESPACE));
        root.write_inner_content(|xml| {
            xml.create_element("Document").write_inner_content(|xml| {
                element(xml, "name", &route.name)?;
                folder(xml, "Route", |xml| {
                    let line: Vec<[f64; 2]> =
                        route.waypoints.iter().map(|w| [w.lon_deg, w.lat_deg]).collect();
                    placemark(xml, &route.name, None, "LineString", &line)?;
                    (0..route.waypoints.len()).try_for_each(|index| waypoint(xml, route, index))
                })?;
                folder(xml, "Track", |xml| tracks.iter().try_for_each(|own| track(xml, route, own)))
            })?;
            Ok(())
        })?;
        Ok(())
    })
}

fn folder(xml: &mut Xml, name: &str, content: impl FnOnce(&mut Xml) -> io::Result<()>) -> io::Result<()> {
    let own = xml.create_element("Folder");
    own.write_inner_content(|xml| {
        element(xml, "name", name)?;
        content(xml)
    })?;
    Ok(())
}

fn waypoint(xml: &mut Xml, route: &Route, index: usize) -> io::Result<()> {
    let own = &route.waypoints[index];
    let name = if own.name.is_empty() { own.id.to_string() } else { own.name.clone() };
    let time = route.instant(index);
    let detail =
        [own.note.as_str(), time.as_deref().unwrap_or("")].into_iter().filter(|text| !text.is_empty());
    let detail: Vec<&str> = detail.collect();
    placemark(xml, &name, Some(Detail::Text(&detail.join(", "))), "Point", &[[own.lon_deg, own.lat_deg]])
}

fn track(xml: &mut Xml, route: &Route, track: &Track) -> io::Result<()> {
    let at = |index: usize| instant(route.departure?, track.time_s(index));
    let span = at(0).zip(at(track.points.len().saturating_sub(1)));
    let detail = span.as_ref().map(|(begin, end)| Detail::Span(begin, end));
    placemark(xml, &track.name, detail, "LineString", &track.points)
}

/// The description or time span of a placemark.
enum Detail<'a> {
    Text(&'a str),
    Span(&'a str, &'a str),
}

fn placemark(
    xml: &mut Xml,
    name: &str,
    detail: Option<Detail>,
    kind: &str,
    places: &[[f64; 2]],
) -> io::Result<()> {
    let tuple = |[lon, lat]: &[f64; 2]| format!("{},{}", longitude(*lon), latitude(*lat));
    let places: Vec<String> = places.iter().map(tuple).collect();
    xml.create_element("Placemark").write_inner_content(|xml| {
        element(xml, "name", name)?;
        match detail {
            Some(Detail::Text(text)) if !text.is_empty() => element(xml, "description", text)?,
            Some(Detail::Span(begin, end)) => {
                xml.create_element("TimeSpan").write_inner_content(|xml| {
                    element(xml, "begin", begin)?;
                    element(xml, "end", end)
                })?;
            }
            _ => {}
        }
        xml.create_element(kind)
            .write_inner_content(|xml| {
                if kind == "LineString" {
                    element(xml, "tessellate", "1")?;
                }
                element(xml, "coordinates", &places.join(" "))
            })
            .map(|_| ())
    })?;
    Ok(())
}
