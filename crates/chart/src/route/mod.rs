//! Routes and tracks as files: RTZ 1.0 (IEC 61174), GPX 1.1 and GeoJSON (RFC 7946). Pure functions from
//! values to text.

mod geojson;
mod gpx;
mod points;
mod rtz;
mod xml;

pub use geojson::{Feature, Geometry, geojson};
pub use gpx::gpx;
pub use points::{Route, Track, Waypoint};
pub use rtz::rtz;
