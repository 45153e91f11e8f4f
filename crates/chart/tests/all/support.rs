//! Charts for the tests and independent geometry to check against.
#![allow(dead_code)]

use std::path::{Path, PathBuf};

use chart::{Bounds, Chart, Layer, LayerKind, Plane, PolygonLayer};

pub fn fixture(name: &str) -> String {
    let path = fixture_path(name);
    std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

/// Where a chart of the repository is.
pub fn fixture_path(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures/charts").join(name)
}

/// Where a chart is that is not in the repository, if anywhere.
pub fn shared_path(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data/charts").join(name)
}

/// A chart that is not in the repository; says so and gives `None` where it is absent.
pub fn shared(name: &str) -> Option<String> {
    let text = std::fs::read_to_string(shared_path(name)).ok();
    if text.is_none() {
        println!("skipped: {name} is not beside the repository");
    }
    text
}

pub fn square(half: f64) -> Bounds {
    Bounds::new([-half, -half], [half, half]).unwrap()
}

pub fn land(text: &str) -> PolygonLayer {
    PolygonLayer::from_geojson(text, &LayerKind::Land, None).unwrap()
}

pub fn land_chart(text: &str, lon: f64, lat: f64, half: f64) -> Chart {
    let plane = Plane::new(lon, lat).unwrap();
    Chart::new(plane, square(half), &[Layer::Polygons(land(text))], None).unwrap()
}

/// Even-odd point in polygon over closed rings.
pub fn inside(rings: &[Vec<[f64; 2]>], p: [f64; 2]) -> bool {
    let crossings = rings.iter().flat_map(|r| r.windows(2)).filter(|w| {
        let ([x0, y0], [x1, y1]) = (w[0], w[1]);
        (y0 > p[1]) != (y1 > p[1]) && p[0] < x0 + (p[1] - y0) / (y1 - y0) * (x1 - x0)
    });
    crossings.count() % 2 == 1
}

/// Distance of a point from a segment.
pub fn from_segment(p: [f64; 2], a: [f64; 2], b: [f64; 2]) -> f64 {
    let d = [b[0] - a[0], b[1] - a[1]];
    let l = d[0] * d[0] + d[1] * d[1];
    let t = if l > 0.0 { (((p[0] - a[0]) * d[0] + (p[1] - a[1]) * d[1]) / l).clamp(0.0, 1.0) } else { 0.0 };
    (p[0] - a[0] - t * d[0]).hypot(p[1] - a[1] - t * d[1])
}

/// Distance of a point from a polygon of closed rings; 0 inside.
pub fn from_polygon(rings: &[Vec<[f64; 2]>], p: [f64; 2]) -> f64 {
    if inside(rings, p) {
        return 0.0;
    }
    let edges = rings.iter().flat_map(|r| r.windows(2));
    edges.map(|w| from_segment(p, w[0], w[1])).fold(f64::INFINITY, f64::min)
}
