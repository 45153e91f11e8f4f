//! What GeoJSON files are read and refused.

use chart::ring::{RingFault, ring_fault};
use chart::{Class, Filter, LayerKind, PolygonLayer};
use proptest::prelude::*;

use crate::support::{fixture, land};

fn polygon(rings: &str) -> String {
    format!(
        r#"{{"type": "Feature", "properties": null, "geometry": {{"type": "Polygon", "coordinates": [{rings}]}}}}"#
    )
}

fn refusal(text: &str) -> String {
    let message = PolygonLayer::from_geojson(text, &LayerKind::Land, None).unwrap_err().to_string();
    assert!(!message.contains('\n'), "{message}");
    message
}

fn depth_kind() -> LayerKind {
    LayerKind::Depth { least: "DRVAL1".to_owned() }
}

fn objl(values: &[&str]) -> Filter {
    Filter { property: "objl".to_owned(), values: values.iter().map(|v| (*v).to_owned()).collect() }
}

#[test]
fn holes_and_points_are_kept() {
    let layer = land(&fixture("square_island.geojson"));
    assert_eq!(layer.areas.len(), 1);
    assert_eq!(layer.areas[0].rings.len(), 2);
    assert_eq!(layer.marks.len(), 1);
}

#[test]
fn depths_are_read_from_numbers_and_text_and_filtered() {
    let layer = PolygonLayer::from_geojson(
        &fixture("channel.geojson"),
        &depth_kind(),
        Some(&objl(&["DEPARE", "DRGARE"])),
    )
    .unwrap();
    let least: Vec<_> = layer
        .areas
        .iter()
        .map(|a| match a.class {
            Class::Depth { least_m, .. } => least_m,
            _ => unreachable!(),
        })
        .collect();
    assert_eq!(least, [Some(0.0), Some(10.5), Some(12.0), None]);
    assert_eq!(layer.filtered_out, 1);
    assert_eq!(layer.areas.iter().map(|a| a.feature).collect::<Vec<_>>(), [0, 1, 2, 3]);
}

#[test]
fn numbers_pass_a_filter_by_their_text() {
    let text = r#"{"type": "Feature", "properties": {"objl": 42, "DRVAL1": 3}, "geometry": {"type": "MultiPolygon",
        "coordinates": [[[[0,0],[1,0],[1,1],[0,0]]], [[[2,0],[3,0],[3,1],[2,0]]]]}}"#;
    let layer = PolygonLayer::from_geojson(text, &depth_kind(), Some(&objl(&["42"]))).unwrap();
    assert_eq!(layer.areas.len(), 2);
    assert!(PolygonLayer::from_geojson(text, &depth_kind(), Some(&objl(&["71"]))).is_err());
}

#[test]
fn projected_coordinates_are_refused() {
    for text in [
        polygon("[[385000,6670000],[385100,6670000],[385100,6670100],[385000,6670000]]"),
        polygon("[[24,60],[24,91],[25,91],[24,60]]"),
        r#"{"type": "FeatureCollection", "crs": {"type": "name", "properties": {"name": "urn:ogc:def:crs:EPSG::3067"}},
            "features": []}"#
            .to_owned(),
    ] {
        assert!(refusal(&text).contains("mixed CRS"), "{text}");
    }
    let named = |name: &str| {
        format!(
            r#"{{"type": "FeatureCollection", "crs": {{"type": "name", "properties": {{"name": "{name}"}}}},
            "features": [{}]}}"#,
            polygon("[[0,0],[1,0],[1,1],[0,0]]")
        )
    };
    for name in ["urn:ogc:def:crs:OGC:1.3:CRS84", "EPSG:4326", "urn:ogc:def:crs:EPSG::4326"] {
        assert_eq!(land(&named(name)).areas.len(), 1);
    }
    assert!(refusal(&named("EPSG:32635")).contains("EPSG:32635"));
}

#[test]
fn broken_rings_are_refused_by_feature() {
    let cases = [
        ("", "empty polygon"),
        ("[]", "empty polygon"),
        ("[[0,0],[1,0],[0,0]]", "empty polygon"),
        ("[[0,0],[1,1],[2,2],[0,0]]", "empty polygon"),
        ("[[0,0],[1,0],[1,1],[0,1]]", "open ring"),
        ("[[0,0],[1,1],[1,0],[0,1],[0,0]]", "crosses"),
        ("[[0],[1,1],[1,0],[0,1],[0,0]]", "fewer than two"),
        ("[[0,0],[NaN,1],[1,0],[0,0]]", "GeoJSON"),
        ("[[0,0],[1e999,1],[1,0],[0,0]]", "GeoJSON"),
        ("[[0,0],[4,0],[4,4],[0,4],[0,0]],[[1,1],[1,2],[5,2],[5,1],[1,1]]", "crosses"),
    ];
    for (rings, expected) in cases {
        let message = refusal(&polygon(rings));
        assert!(message.contains(expected), "{rings}: {message}");
        assert!(expected == "GeoJSON" || message.contains("feature 0"), "{message}");
    }
    let bow_tie = refusal(&fixture("self_crossing.geojson"));
    assert!(bow_tie.contains("feature 1, ring 0") && bow_tie.contains("crosses"), "{bow_tie}");
}

#[test]
fn rings_that_only_touch_themselves_are_read() {
    // Two triangles that meet in a point, a spike, a hole that touches the shore.
    for rings in [
        "[[0,0],[1,1],[2,0],[2,2],[1,1],[0,2],[0,0]]",
        "[[0,0],[2,0],[2,1],[3,1],[2,1],[2,2],[0,2],[0,0]]",
        "[[0,0],[4,0],[4,4],[0,4],[0,0]],[[2,0],[3,2],[1,2],[2,0]]",
    ] {
        assert_eq!(land(&polygon(rings)).areas.len(), 1, "{rings}");
    }
}

#[test]
fn files_without_anything_charted_are_refused() {
    let corrupt = fixture("square_island.geojson");
    for text in ["", "{", "[]", "null", "{\"type\": \"FeatureCollection\"}", &corrupt[..corrupt.len() / 2]] {
        assert!(refusal(text).contains("GeoJSON"), "{text}");
    }
    assert!(refusal(r#"{"type": "FeatureCollection", "features": []}"#).contains("nothing charted"));
}

#[test]
fn depth_properties_that_make_no_sense_are_refused() {
    let feature = |depth: &str| {
        polygon("[[0,0],[1,0],[1,1],[0,0]]")
            .replace("\"properties\": null", &format!("\"properties\": {{\"DRVAL1\": {depth}}}"))
    };
    let read = |text: &str, least: &str| {
        let kind = LayerKind::Depth { least: least.to_owned() };
        PolygonLayer::from_geojson(text, &kind, None).map_err(|e| e.to_string())
    };
    assert!(read(&feature("\"deep\""), "DRVAL1").unwrap_err().contains("deep"));
    assert!(read(&feature("true"), "DRVAL1").is_err());
    assert!(read(&feature("3"), "depth").unwrap_err().contains("`depth`"));
    let sign = read(&feature("-12.5"), "DRVAL1").unwrap_err();
    assert!(sign.contains("-12.5..-12.5") && sign.contains("positive down"), "{sign}");
    assert!(read(&feature("null"), "DRVAL1").is_ok());
    for fill in ["-32768", "9.97e36", "\"NaN\"", "\"-inf\""] {
        let refused = read(&feature(fill), "DRVAL1").unwrap_err();
        assert!(refused.contains("feature 0") && refused.contains("at most 12000 m"), "{refused}");
    }
}

/// Twice the area of a triangle of whole numbers: exact.
fn turn(a: [i64; 2], b: [i64; 2], c: [i64; 2]) -> i64 {
    ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])).signum()
}

fn brute_crossing(rings: &[Vec<[i64; 2]>]) -> bool {
    let edges: Vec<_> = rings.iter().flat_map(|r| r.windows(2)).collect();
    edges.iter().enumerate().any(|(i, e)| {
        edges[..i].iter().any(|f| {
            turn(e[0], e[1], f[0]) * turn(e[0], e[1], f[1]) < 0
                && turn(f[0], f[1], e[0]) * turn(f[0], f[1], e[1]) < 0
        })
    })
}

fn ring(size: i64) -> impl Strategy<Value = Vec<[i64; 2]>> {
    prop::collection::vec(prop::array::uniform2(0..size), 3..14).prop_map(|mut r| {
        r.push(r[0]);
        r
    })
}

/// A ring around a centre: free of crossings unless the angles happen to repeat.
fn star() -> impl Strategy<Value = Vec<[i64; 2]>> {
    prop::collection::vec(50..1000_i64, 3..200).prop_map(|radii| {
        let n = radii.len() as f64;
        let at = |(i, r): (usize, &i64)| {
            let (sin, cos) = (std::f64::consts::TAU * i as f64 / n).sin_cos();
            [(*r as f64 * cos).round() as i64, (*r as f64 * sin).round() as i64]
        };
        let mut ring: Vec<_> = radii.iter().enumerate().map(at).collect();
        ring.push(ring[0]);
        ring
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]
    #[test]
    fn oracle_crossings_are_those_of_all_pairs(
        rings in prop::collection::vec(prop_oneof![ring(5), ring(40), ring(1_000_000), star()], 1..3),
        power in -20..1_i32,
    ) {
        // Powers of two keep whole numbers exact.
        let scale = f64::from(power).exp2();
        let real: Vec<Vec<[f64; 2]>> =
            rings.iter().map(|r| r.iter().map(|p| p.map(|v| v as f64 * scale)).collect()).collect();
        match ring_fault(&real) {
            Some(RingFault::Crossing { .. }) => prop_assert!(brute_crossing(&rings)),
            None => prop_assert!(!brute_crossing(&rings)),
            Some(RingFault::Empty { ring }) => {
                let area: i64 = rings[ring].windows(2).map(|w| w[0][0] * w[1][1] - w[1][0] * w[0][1]).sum();
                prop_assert_eq!(area, 0);
                prop_assert!(!brute_crossing(&rings));
            }
            Some(other) => prop_assert!(false, "{:?}", other),
        }
    }
}
