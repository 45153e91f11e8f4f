//! Points and lines of charts: dangers with their radius, never left out.

use chart::{Bounds, Causes, Chart, Layer, LayerKind, Obstacles, Plane, PolygonLayer, Raster, Uncharted};

use crate::support::{from_segment, square};

const CELL_M: f64 = 10.0;

fn feature(geometry: &str, properties: &str) -> String {
    format!(r#"{{"type": "Feature", "properties": {properties}, "geometry": {geometry}}}"#)
}

fn geometry(kind: &str, coordinates: &str) -> String {
    format!(r#"{{"type": "{kind}", "coordinates": {coordinates}}}"#)
}

fn danger() -> LayerKind {
    LayerKind::Danger { least: "VALSOU".to_owned() }
}

fn layer(text: &str, kind: &LayerKind) -> PolygonLayer {
    PolygonLayer::from_geojson(text, kind, None).unwrap()
}

fn chart(layers: Vec<PolygonLayer>) -> Chart {
    let plane = Plane::new(25.0, 60.0).unwrap();
    let layers: Vec<Layer> = layers.into_iter().map(Layer::Polygons).collect();
    Chart::new(plane, square(1500.0), &layers, None).unwrap()
}

fn obstacles(chart: &Chart, least_depth_m: f64) -> Obstacles {
    Obstacles::new(chart, Raster::covering(&square(1000.0), CELL_M).unwrap(), least_depth_m, 0.0).unwrap()
}

fn cause_at(obstacles: &Obstacles, point: [f64; 2]) -> Causes {
    let (col, row) = obstacles.raster().cell_at(point).unwrap();
    obstacles.causes(col, row)
}

/// Every cell with a point within `radius_m` of the lines is an obstacle, and none farther than a little more.
fn assert_around(text: &str, radius_m: f64, lines: &[&[[f64; 2]]]) {
    let chart = chart(vec![layer(text, &LayerKind::Land).with_danger(radius_m)]);
    let (obstacles, plane) = (obstacles(&chart, 0.0), *chart.plane());
    let placed: Vec<Vec<[f64; 2]>> =
        lines.iter().map(|line| line.iter().map(|p| plane.to_plane(p[0], p[1])).collect()).collect();
    let raster = obstacles.raster();
    let mut counts = [0; 2];
    for k in 0..raster.nx * raster.ny {
        let (col, row) = (k % raster.nx, k / raster.nx);
        let centre = raster.node(col, row).map(|o| o + CELL_M / 2.0);
        let segments = placed.iter().flat_map(|line| line.windows(line.len().min(2)));
        let away = segments.map(|w| from_segment(centre, w[0], w[w.len() - 1])).fold(f64::INFINITY, f64::min);
        let is = obstacles.causes(col, row).any();
        assert!(is || away > radius_m, "{centre:?} is {away} m away and free");
        assert!(
            !is || away <= 1.03 * radius_m + CELL_M * 0.75,
            "{centre:?} is {away} m away and an obstacle"
        );
        counts[usize::from(is)] += 1;
    }
    assert!(counts.iter().all(|n| *n > 50), "{counts:?}");
}

#[test]
fn law_every_geometry_of_points_and_lines_is_an_obstacle_as_far_as_its_danger() {
    let [a, b, c] = [[24.995, 60.001], [25.004, 60.004], [25.006, 59.997]];
    let (one, line) = (format!("{a:?}"), format!("[{a:?}, {b:?}, {c:?}]"));
    assert_around(&feature(&geometry("Point", &one), "{}"), 80.0, &[&[a]]);
    assert_around(&feature(&geometry("MultiPoint", &line), "{}"), 60.0, &[&[a], &[b], &[c]]);
    assert_around(&feature(&geometry("LineString", &line), "{}"), 35.0, &[&[a, b, c]]);
    let lines = format!("[[{a:?}, {b:?}], [{c:?}, {c:?}]]");
    assert_around(&feature(&geometry("MultiLineString", &lines), "{}"), 35.0, &[&[a, b], &[c]]);
    let both = format!(
        r#"{{"type": "GeometryCollection", "geometries": [{}, {}]}}"#,
        geometry("Point", &format!("{c:?}")),
        geometry("LineString", &format!("[{a:?}, {b:?}]"))
    );
    assert_around(&feature(&both, "{}"), 50.0, &[&[c], &[a, b]]);
}

#[test]
fn a_danger_is_no_obstacle_only_where_its_depth_is_known_and_enough() {
    let at = |lon: f64, depth: &str| {
        feature(&geometry("Point", &format!("[{lon}, 60.0]")), &format!(r#"{{"VALSOU": {depth}}}"#))
    };
    let all = [at(24.99, "4.5"), at(25.0, "null"), at(25.01, "\"12\"")].join(", ");
    let text = format!(r#"{{"type": "FeatureCollection", "features": [{all}]}}"#);
    let chart = chart(vec![layer(&text, &danger())]);
    assert!(!chart.has_depth() && chart.uncharted() == Uncharted::Water);
    let blocked = |depth: f64| {
        let obstacles = obstacles(&chart, depth);
        [-558.0, 0.0, 558.0].map(|x| cause_at(&obstacles, [x, 5.0]) == Causes::SHOAL)
    };
    assert_eq!(blocked(4.0), [false, true, false]);
    assert_eq!(blocked(5.0), [true, true, false]);
    assert_eq!(blocked(12.5), [true, true, true]);
}

#[test]
fn a_sounding_or_a_danger_charts_no_water() {
    let square = |half: f64| {
        let (w, e, s, n) = (25.0 - half, 25.0 + half, 60.0 - half, 60.0 + half);
        geometry("Polygon", &format!("[[[{w},{s}],[{e},{s}],[{e},{n}],[{w},{n}],[{w},{s}]]]"))
    };
    let water = feature(&square(0.003), r#"{"DRVAL1": 10}"#);
    let sounding = feature(&geometry("Point", "[25.01, 60.0]"), r#"{"DRVAL1": 10}"#);
    let depths = format!(r#"{{"type": "FeatureCollection", "features": [{water}, {sounding}]}}"#);
    let kind = LayerKind::Depth { least: "DRVAL1".to_owned() };
    let wide = feature(&square(0.006), r#"{"VALSOU": 10}"#);
    let obstacles = obstacles(&chart(vec![layer(&depths, &kind), layer(&wide, &danger())]), 5.0);
    assert_eq!(cause_at(&obstacles, [0.0, 5.0]), Causes::NONE);
    assert_eq!(
        cause_at(&obstacles, [250.0, 5.0]),
        Causes::UNCHARTED,
        "over a deep wreck next to charted water"
    );
    assert_eq!(
        cause_at(&obstacles, [558.0, 5.0]),
        Causes::UNCHARTED,
        "at a deep sounding next to charted water"
    );
}

#[test]
fn features_without_a_place_are_refused_with_their_count() {
    let text = format!(
        r#"{{"type": "FeatureCollection", "features": [{}, {}, {}]}}"#,
        feature("null", "{}"),
        feature(&geometry("Point", "[25.0, 60.0]"), "{}"),
        feature(&geometry("MultiPoint", "[]"), "{}")
    );
    let refused = PolygonLayer::from_geojson(&text, &LayerKind::Land, None).unwrap_err().to_string();
    assert!(
        refused.contains("2 of 3 features without a geometry") && refused.contains("`only`"),
        "{refused}"
    );
    let text = feature(&geometry("Point", "[385000.0, 6671000.0]"), "{}");
    let refused = PolygonLayer::from_geojson(&text, &LayerKind::Land, None).unwrap_err().to_string();
    assert!(refused.contains("mixed CRS") && refused.contains("feature 0"), "{refused}");
}

#[test]
fn a_point_just_outside_of_the_area_reaches_into_it() {
    let text = feature(&geometry("Point", "[25.0272, 60.0]"), "{}");
    let chart = chart(vec![layer(&text, &LayerKind::NoGo).with_danger(100.0)]);
    let bounds = chart.polygons()[0].bounds;
    assert!(bounds.min[0] < 1500.0 && bounds.max[0] > 1590.0, "{bounds:?}");
    assert!(chart.drawn(&Bounds::new([0.0, -10.0], [1500.0, 10.0]).unwrap()).len() == 1);
}
