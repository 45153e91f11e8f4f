//! A plan's passage and track for QGIS: layers with their styles in one file.

mod layers;
mod package;

use refusal::Invalid;
use study::plan::{Geometry, Routes};

use layers::Layers;
pub use package::{Column, Shape, StyledLayer, package};

/// The plan of `routes` as a GeoPackage.
///
/// # Errors
/// See [`package`].
pub fn geopackage(routes: &Routes) -> Result<Vec<u8>, Invalid> {
    let (plane, passage, label) = (routes.plane, &routes.voyage.passage, routes.label());
    let (route, mut tracks) = (&routes.route(), routes.features());
    tracks.retain(|feature| matches!(feature.geometry, Geometry::Line(_)));
    package(&Layers { plane, route, passage, tracks, label }.all(), route.departure)
}
