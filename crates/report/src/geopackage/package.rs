//! GeoPackage 1.3 (OGC 12-128r17): layers with their styles in one SQLite file.

use std::iter::once;

use refusal::Invalid;
use rusqlite::types::Value;
use rusqlite::{Connection, params, params_from_iter};
use study::plan::{Feature, Geometry, Timestamp, later, rounded};

const SCHEMA: &str = include_str!("package.sql");

/// A layer of a GeoPackage, in longitude and latitude of WGS84.
#[derive(Clone, Debug, PartialEq)]
pub struct StyledLayer {
    /// Name of its table: lower-case letters and `_`; unique.
    pub name: &'static str,
    /// Its title for users; unique.
    pub title: String,
    /// The shape of its features.
    pub shape: Shape,
    /// Columns besides the geometry: properties of the features, by name. Missing ones are null.
    pub columns: &'static [(&'static str, Column)],
    /// In drawing order.
    pub features: Vec<Feature>,
    /// How QGIS draws it (QML).
    pub style: &'static str,
}

/// The shape of the features of a layer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shape {
    /// Places.
    Point,
    /// Lines.
    Line,
    /// Areas.
    Polygon,
}

/// The type of a column.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Column {
    /// Text.
    Text,
    /// A whole number.
    Integer,
    /// A number.
    Real,
    /// True or false.
    Boolean,
    /// A time of day in UTC; the property holds seconds after the departure.
    Time,
}

/// The layers as a GeoPackage, each with a style that QGIS uses when it loads the layer. A shape across the
/// antimeridian continues beyond ±180°. The layers' last change is the departure, or 1970 without one, so
/// that equal layers give equal bytes.
///
/// # Errors
/// Coordinates that are not finite or out of range; a line of fewer than two points, a polygon of fewer than four; a shape that
/// is not its layer's; two layers of one name.
pub fn package(layers: &[StyledLayer], departure: Option<Timestamp>) -> Result<Vec<u8>, Invalid> {
    let failed = |e: rusqlite::Error| {
        Invalid::new("GeoPackage", e.to_string(), "layers that SQLite can hold", "report this as a defect")
    };
    let shapes: Vec<Vec<Vec<[f64; 2]>>> = layers.iter().map(shapes).collect::<Result<_, Invalid>>()?;
    Package::new(departure).and_then(|mut package| package.written(layers, &shapes)).map_err(failed)
}

/// The positions of a layer's features.
fn shapes(layer: &StyledLayer) -> Result<Vec<Vec<[f64; 2]>>, Invalid> {
    let own = |(index, feature): (usize, &Feature)| {
        let thing = format!("layer `{}`, feature {index}", layer.name);
        let (shape, places) = match &feature.geometry {
            Geometry::Point(place) => (Shape::Point, std::slice::from_ref(place)),
            Geometry::Line(line) => (Shape::Line, line.as_slice()),
            Geometry::Polygon(ring) => (Shape::Polygon, ring.as_slice()),
        };
        if shape != layer.shape {
            let (found, expected) = (shape.name(), layer.shape.name());
            return Err(Invalid::new(thing, found, expected, "put it into a layer of its own"));
        }
        let mut places = rounded(places, shape.least_points(), &thing)?;
        let first = places[0][0];
        places.iter_mut().for_each(|place| place[0] -= 360.0 * ((place[0] - first) / 360.0).round());
        Ok(places)
    };
    layer.features.iter().enumerate().map(own).collect()
}

/// A package while it is written.
struct Package {
    connection: Connection,
    departure: Option<Timestamp>,
}

impl Package {
    fn new(departure: Option<Timestamp>) -> rusqlite::Result<Self> {
        let connection = Connection::open_in_memory()?;
        connection.execute_batch(SCHEMA)?;
        Ok(Self { connection, departure })
    }

    fn written(
        &mut self,
        layers: &[StyledLayer],
        shapes: &[Vec<Vec<[f64; 2]>>],
    ) -> rusqlite::Result<Vec<u8>> {
        for (layer, shapes) in layers.iter().zip(shapes) {
            self.list(layer, shapes)?;
            self.fill(layer, shapes)?;
        }
        self.connection.execute(
            "INSERT INTO gpkg_contents (table_name, data_type, identifier, last_change, srs_id)
             VALUES ('layer_styles', 'attributes', 'layer_styles', ?, 0)",
            [self.changed()],
        )?;
        Ok(self.connection.serialize("main")?.to_vec())
    }

    /// The layers' last change.
    fn changed(&self) -> String {
        moment(self.departure.unwrap_or(Timestamp::UNIX_EPOCH))
    }

    /// Registers a layer and its style.
    fn list(&self, layer: &StyledLayer, shapes: &[Vec<[f64; 2]>]) -> rusqlite::Result<()> {
        let StyledLayer { name, title, shape, style, .. } = layer;
        let extent = extent(shapes.iter().flatten()).map_or([None; 4], |extent| extent.map(Some));
        let [west, east, south, north] = extent;
        self.connection.execute(
            "INSERT INTO gpkg_contents VALUES (?, 'features', ?, '', ?, ?, ?, ?, ?, 4326)",
            params![name, title, self.changed(), west, south, east, north],
        )?;
        self.connection.execute(
            "INSERT INTO gpkg_geometry_columns VALUES (?, 'geom', ?, 4326, 0, 0)",
            params![name, shape.name()],
        )?;
        self.connection.execute(
            "INSERT INTO layer_styles (f_table_catalog, f_table_schema, f_table_name, f_geometry_column, styleName, styleQML,
             styleSLD, useAsDefault, description, owner, update_time) VALUES ('', '', ?1, 'geom', ?1, ?2, '', 1, ?3, '', ?4)",
            params![name, style, title, self.changed()],
        )?;
        Ok(())
    }

    /// Creates the table of a layer.
    fn fill(&self, layer: &StyledLayer, shapes: &[Vec<[f64; 2]>]) -> rusqlite::Result<()> {
        let StyledLayer { name, shape, columns, features, .. } = layer;
        let declared: String =
            columns.iter().map(|(name, column)| format!(", {name} {}", column.name())).collect();
        let table = format!(
            "CREATE TABLE {name} (fid INTEGER PRIMARY KEY NOT NULL, geom {}{declared})",
            shape.name()
        );
        self.connection.execute_batch(&table)?;
        let places = ", ?".repeat(columns.len());
        let mut row = self.connection.prepare(&format!("INSERT INTO {name} VALUES (NULL, ?{places})"))?;
        for (feature, places) in features.iter().zip(shapes) {
            let values =
                columns.iter().map(|(name, column)| self.value(*column, feature.properties.get(*name)));
            row.execute(params_from_iter(once(Value::Blob(blob(*shape, places))).chain(values)))?;
        }
        Ok(())
    }

    fn value(&self, column: Column, property: Option<&serde_json::Value>) -> Value {
        let value = match (column, property) {
            (Column::Text, Some(own)) => own.as_str().map(|text| Value::Text(text.to_owned())),
            (Column::Integer, Some(own)) => own.as_i64().map(Value::Integer),
            (Column::Real, Some(own)) => own.as_f64().map(Value::Real),
            (Column::Boolean, Some(own)) => own.as_bool().map(|own| Value::Integer(own.into())),
            (Column::Time, Some(own)) => {
                let after = own.as_f64().zip(self.departure);
                after.and_then(|(s, departure)| later(departure, s)).map(|at| Value::Text(moment(at)))
            }
            (_, None) => None,
        };
        value.unwrap_or(Value::Null)
    }
}

impl Shape {
    const fn name(self) -> &'static str {
        match self {
            Self::Point => "POINT",
            Self::Line => "LINESTRING",
            Self::Polygon => "POLYGON",
        }
    }

    const fn least_points(self) -> usize {
        match self {
            Self::Point => 1,
            Self::Line => 2,
            Self::Polygon => 4,
        }
    }
}

impl Column {
    const fn name(self) -> &'static str {
        match self {
            Self::Text => "TEXT",
            Self::Integer => "INTEGER",
            Self::Real => "REAL",
            Self::Boolean => "BOOLEAN",
            Self::Time => "DATETIME",
        }
    }
}

/// ISO 8601 in UTC, to the millisecond, as the format requires.
fn moment(at: Timestamp) -> String {
    format!("{at:.3}")
}

/// Least and largest longitude, least and largest latitude.
fn extent<'a>(places: impl IntoIterator<Item = &'a [f64; 2]>) -> Option<[f64; 4]> {
    let grown = |extent: Option<[f64; 4]>, [lon, lat]: &[f64; 2]| {
        let [west, east, south, north] = extent.unwrap_or([*lon, *lon, *lat, *lat]);
        Some([west.min(*lon), east.max(*lon), south.min(*lat), north.max(*lat)])
    };
    places.into_iter().fold(None, grown)
}

/// A geometry: the format's header, with the extent unless it is a point, then well-known binary, all
/// little-endian.
fn blob(shape: Shape, places: &[[f64; 2]]) -> Vec<u8> {
    let extent = extent(places).filter(|_| shape != Shape::Point);
    // Version 0; flags: byte order, and the kind of extent.
    let mut blob = vec![b'G', b'P', 0, if extent.is_some() { 0b11 } else { 0b01 }];
    blob.extend(4326_i32.to_le_bytes());
    blob.extend(extent.iter().flatten().flat_map(|v| v.to_le_bytes()));
    let count = u32::try_from(places.len()).unwrap_or(u32::MAX);
    let (kind, counts): (u32, &[u32]) = match shape {
        Shape::Point => (1, &[]),
        Shape::Line => (2, &[count]),
        Shape::Polygon => (3, &[1, count]),
    };
    blob.push(1);
    blob.extend(once(&kind).chain(counts).flat_map(|v| v.to_le_bytes()));
    blob.extend(places.iter().flatten().flat_map(|v| v.to_le_bytes()));
    blob
}
