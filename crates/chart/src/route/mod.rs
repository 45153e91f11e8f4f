//! Routes and tracks as files: RTZ 1.0 (IEC 61174), GPX 1.1, KML 2.2, QGroundControl's plans, GeoJSON (RFC 7946) and
//! GeoPackage 1.3. Pure functions from values to text, or to the bytes of a GeoPackage.

mod geojson;
mod geopackage;
mod gpx;
mod kml;
mod points;
mod qgroundcontrol;
mod rtz;
mod xml;

pub use geojson::{Feature, Geometry, geojson};
pub use geopackage::{Column, Shape, StyledLayer, geopackage};
pub use gpx::gpx;
pub use jiff::Timestamp;
pub use kml::kml;
pub use points::{Route, Track, Waypoint};
pub use qgroundcontrol::qgroundcontrol;
pub use rtz::rtz;
