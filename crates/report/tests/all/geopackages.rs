//! GeoPackages, read back by SQLite and by the format's specification (OGC 12-128r17).

use report::geopackage::{Column, Shape, StyledLayer, package};
use rusqlite::Connection;
use rusqlite::types::Value;
use serde_json::json;
use study::plan::{Feature, Geometry, Timestamp};

/// A place, a line whose shape needs several pages, and an area.
fn layers() -> Vec<StyledLayer> {
    let layer = |name, shape, geometry, properties: serde_json::Value| StyledLayer {
        name,
        title: format!("the {name}"),
        shape,
        columns: &[
            ("what", Column::Text),
            ("count", Column::Integer),
            ("depth_m", Column::Real),
            ("safe", Column::Boolean),
            ("eta", Column::Time),
        ],
        features: vec![Feature { geometry, properties: properties.as_object().cloned().unwrap() }],
        style: "<qgis/>",
    };
    let line = (0..900).map(|i| [24.9 + f64::from(i) * 1e-5, 60.1 - f64::from(i) * 2e-5]).collect();
    let ring = vec![[24.0, 60.0], [24.5, 60.0], [24.5, 60.5], [24.0, 60.0]];
    let properties =
        json!({"what": "zig-zag 20°/20° 'A'", "count": 3, "depth_m": 12.5, "safe": true, "eta": 90.25});
    vec![
        layer("places", Shape::Point, Geometry::Point([-24.25, -60.125]), properties),
        layer("lines", Shape::Line, Geometry::Line(line), json!({"depth_m": null, "other": 1})),
        layer("areas", Shape::Polygon, Geometry::Polygon(ring), json!({"safe": false, "depth_m": 7})),
    ]
}

fn departure() -> Timestamp {
    "2026-06-01T08:00:00Z".parse().unwrap()
}

fn opened(bytes: &[u8]) -> Connection {
    let mut connection = Connection::open_in_memory().unwrap();
    connection.deserialize_read_exact("main", bytes, bytes.len(), true).unwrap();
    connection
}

fn rows(connection: &Connection, query: &str) -> Vec<Vec<Value>> {
    let mut statement = connection.prepare(query).unwrap();
    let columns = statement.column_count();
    let rows = statement.query_map([], |row| (0..columns).map(|i| row.get(i)).collect());
    rows.unwrap().map(Result::unwrap).collect()
}

fn text(text: &str) -> Value {
    Value::Text(text.to_owned())
}

/// The extent, if there is one, and the points of a geometry, which begin `before` bytes into its well-known binary.
fn decoded(blob: &[u8], kind: u32, before: usize) -> (Vec<f64>, Vec<[f64; 2]>) {
    let numbers = |bytes: &[u8]| -> Vec<f64> {
        bytes.chunks_exact(8).map(|own| f64::from_le_bytes(own.try_into().unwrap())).collect()
    };
    assert_eq!((&blob[..3], &blob[4..8]), (&b"GP\0"[..], &4326_i32.to_le_bytes()[..]));
    let extent = 32 * usize::from(blob[3] >> 1);
    assert_eq!(blob[3] & 1, 1, "little-endian");
    let (extent, binary) = blob[8..].split_at(extent);
    assert_eq!((binary[0], &binary[1..5]), (1, &kind.to_le_bytes()[..]));
    let points: Vec<[f64; 2]> =
        numbers(&binary[before..]).chunks_exact(2).map(|own| [own[0], own[1]]).collect();
    if before > 5 {
        let count = u32::try_from(points.len()).unwrap();
        assert_eq!(&binary[before - 4..before], count.to_le_bytes());
    }
    (numbers(extent), points)
}

#[test]
fn law_a_geopackage_lists_all_that_it_holds() {
    let bytes = package(&layers(), Some(departure())).unwrap();
    assert_eq!((&bytes[..16], &bytes[68..72]), (&b"SQLite format 3\0"[..], &b"GPKG"[..]));
    assert_eq!(bytes[60..64], 10_300_u32.to_be_bytes());
    let file = opened(&bytes);
    assert_eq!(rows(&file, "PRAGMA integrity_check"), [[text("ok")]]);
    assert!(rows(&file, "PRAGMA foreign_key_check").is_empty());
    let systems = rows(&file, "SELECT srs_id FROM gpkg_spatial_ref_sys ORDER BY srs_id");
    assert_eq!(systems, [-1, 0, 4326].map(|id| vec![Value::Integer(id)]));
    let changed = text("2026-06-01T08:00:00.000Z");
    let contents =
        "SELECT table_name, data_type, identifier, last_change, srs_id FROM gpkg_contents ORDER BY rowid";
    let listed = |name: &str| {
        vec![
            text(name),
            text("features"),
            text(&format!("the {name}")),
            changed.clone(),
            Value::Integer(4326),
        ]
    };
    let styles = vec![
        text("layer_styles"),
        text("attributes"),
        text("layer_styles"),
        changed.clone(),
        Value::Integer(0),
    ];
    assert_eq!(rows(&file, contents), [listed("places"), listed("lines"), listed("areas"), styles]);
    let shapes =
        rows(&file, "SELECT table_name, geometry_type_name FROM gpkg_geometry_columns ORDER BY rowid");
    let expected = [("places", "POINT"), ("lines", "LINESTRING"), ("areas", "POLYGON")];
    assert_eq!(shapes, expected.map(|(name, shape)| vec![text(name), text(shape)]));
    // The query of QGIS for the style of a layer.
    for (name, _) in expected {
        let query = format!(
            "SELECT styleQML, useAsDefault FROM layer_styles WHERE f_table_schema = '' AND f_table_name = '{name}' AND f_geometry_column = 'geom'"
        );
        assert_eq!(rows(&file, &query), [[text("<qgis/>"), Value::Integer(1)]]);
    }
}

#[test]
fn law_geometries_and_properties_are_read_back() {
    let all = layers();
    let file = opened(&package(&all, Some(departure())).unwrap());
    for (layer, (kind, before)) in all.iter().zip([(1, 5), (2, 9), (3, 13)]) {
        let read = rows(&file, &format!("SELECT * FROM {}", layer.name));
        let Value::Blob(blob) = &read[0][1] else { panic!("{read:?}") };
        let (extent, points) = decoded(blob, kind, before);
        let expected = match &layer.features[0].geometry {
            Geometry::Point(place) => vec![*place],
            Geometry::Line(places) | Geometry::Polygon(places) => places.clone(),
        };
        assert_eq!(points.len(), expected.len());
        assert!(points.iter().zip(&expected).all(|(a, b)| (0..2).all(|k| (a[k] - b[k]).abs() < 1e-9)));
        let least = |k: usize| points.iter().map(|p| p[k]).fold(f64::INFINITY, f64::min);
        let most = |k: usize| points.iter().map(|p| p[k]).fold(-f64::INFINITY, f64::max);
        let own = [least(0), most(0), least(1), most(1)];
        assert!(if kind == 1 { extent.is_empty() } else { extent == own });
        let listed = "SELECT min_x, max_x, min_y, max_y FROM gpkg_contents WHERE table_name";
        assert_eq!(rows(&file, &format!("{listed} = '{}'", layer.name)), [own.map(Value::Real)]);
    }
    let stored =
        |name: &str| rows(&file, &format!("SELECT what, count, depth_m, safe, eta FROM {name}")).remove(0);
    let eta = text("2026-06-01T08:01:30.250Z");
    let place = [text("zig-zag 20°/20° 'A'"), Value::Integer(3), Value::Real(12.5), Value::Integer(1), eta];
    assert_eq!(stored("places"), place);
    assert!(stored("lines").iter().all(|value| *value == Value::Null));
    assert_eq!(stored("areas")[2..4], [Value::Real(7.0), Value::Integer(0)]);
}

#[test]
fn law_the_same_layers_are_the_same_bytes() {
    let first = package(&layers(), None).unwrap();
    let others = (0..3).map(|_| std::thread::spawn(|| package(&layers(), None).unwrap()));
    assert!(others.map(|other| other.join().unwrap()).all(|other| other == first));
    let file = opened(&first);
    let changed = rows(&file, "SELECT DISTINCT last_change FROM gpkg_contents");
    assert_eq!(changed, [[text("1970-01-01T00:00:00.000Z")]]);
    assert_eq!(rows(&file, "SELECT eta FROM places"), [[Value::Null]], "no time of day without a departure");
}

#[test]
fn a_shape_across_the_antimeridian_continues() {
    let mut layers = layers();
    let ring = vec![[179.5, 1.0], [-179.5, 1.0], [-179.5, 2.0], [179.5, 1.0]];
    layers[2].features[0].geometry = Geometry::Polygon(ring);
    let file = opened(&package(&layers, None).unwrap());
    let extent = rows(&file, "SELECT min_x, max_x FROM gpkg_contents WHERE table_name = 'areas'");
    assert_eq!(extent, [[Value::Real(179.5), Value::Real(180.5)]]);
}

#[test]
fn layers_that_break_the_rules_are_refused() {
    let broken = [
        (Geometry::Polygon(vec![[0.0, 0.0], [1.0, 0.0], [0.0, 0.0]]), "3 points"),
        (Geometry::Polygon(vec![[0.0, f64::NAN]; 4]), "latitude NaN"),
        (Geometry::Polygon(vec![[181.0, 0.0]; 4]), "longitude 181"),
        (Geometry::Line(vec![[0.0, 0.0]; 2]), "LINESTRING"),
    ];
    for (geometry, found) in broken {
        let mut layers = layers();
        layers[2].features[0].geometry = geometry;
        let said = package(&layers, None).unwrap_err().to_string();
        assert!(said.contains(found) && said.contains("layer `areas`, feature 0"), "{said}");
    }
    let twice = package(&[layers(), layers()].concat(), None).unwrap_err().to_string();
    assert!(twice.contains("GeoPackage"), "{twice}");
}
