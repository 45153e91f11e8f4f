//! The polygons, points and lines of a feature, however nested.

use geojson::{Feature, GeometryValue, PolygonType, Position};

/// The parts of a feature; a point is a line of one position.
#[derive(Default)]
pub(crate) struct Geometries<'a> {
    pub polygons: Vec<&'a PolygonType>,
    pub lines: Vec<&'a [Position]>,
}

impl<'a> Geometries<'a> {
    pub(crate) fn of(feature: &'a Feature) -> Self {
        let mut own = Self::default();
        feature.geometry.iter().for_each(|geometry| own.take(&geometry.value));
        own
    }

    fn take(&mut self, value: &'a GeometryValue) {
        match value {
            GeometryValue::Point { coordinates } => self.lines.push(std::slice::from_ref(coordinates)),
            GeometryValue::MultiPoint { coordinates } => self.lines.extend(coordinates.chunks(1)),
            GeometryValue::LineString { coordinates } => self.lines.push(coordinates),
            GeometryValue::MultiLineString { coordinates } => {
                self.lines.extend(coordinates.iter().map(Vec::as_slice))
            }
            GeometryValue::Polygon { coordinates } => self.polygons.push(coordinates),
            GeometryValue::MultiPolygon { coordinates } => self.polygons.extend(coordinates),
            GeometryValue::GeometryCollection { geometries } => {
                geometries.iter().for_each(|geometry| self.take(&geometry.value));
            }
        }
    }
}
