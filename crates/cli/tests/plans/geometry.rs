//! Charts and places, read and measured without the chart crate.

use std::fs;
use std::path::Path;

use serde_json::Value;

/// A polygon: rings of longitude and latitude, the first around the others.
pub struct Polygon {
    pub properties: Value,
    rings: Vec<Vec<[f64; 2]>>,
    /// Its south-western and north-eastern corner.
    corners: [[f64; 2]; 2],
}

/// The polygons of a GeoJSON file.
pub fn polygons(path: &Path) -> Vec<Polygon> {
    polygons_of(&fs::read_to_string(path).unwrap())
}

pub fn polygons_of(text: &str) -> Vec<Polygon> {
    let file: Value = serde_json::from_str(text).unwrap();
    let mut all = Vec::new();
    for feature in file["features"].as_array().unwrap() {
        let coordinates = &feature["geometry"]["coordinates"];
        let parts = match feature["geometry"]["type"].as_str().unwrap() {
            "Polygon" => vec![coordinates.clone()],
            "MultiPolygon" => coordinates.as_array().unwrap().clone(),
            _ => Vec::new(),
        };
        for part in parts {
            let rings: Vec<Vec<[f64; 2]>> = serde_json::from_value(part).unwrap();
            let of = |than: fn(f64, f64) -> f64| {
                [0, 1].map(|k| rings.iter().flatten().map(|p| p[k]).reduce(than).unwrap())
            };
            let corners = [of(f64::min), of(f64::max)];
            all.push(Polygon { properties: feature["properties"].clone(), rings, corners });
        }
    }
    all
}

impl Polygon {
    /// Even-odd rule over all rings.
    pub fn holds(&self, [x, y]: [f64; 2]) -> bool {
        let [[west, south], [east, north]] = self.corners;
        if x < west || x > east || y < south || y > north {
            return false;
        }
        let crosses = |[a, b]: [[f64; 2]; 2]| {
            (a[1] > y) != (b[1] > y) && x < (b[0] - a[0]) * (y - a[1]) / (b[1] - a[1]) + a[0]
        };
        self.edges().filter(|edge| crosses(*edge)).count() % 2 == 1
    }

    fn edges(&self) -> impl Iterator<Item = [[f64; 2]; 2]> {
        self.rings.iter().flat_map(|ring| ring.windows(2).map(|pair| [pair[0], pair[1]]))
    }

    /// Whether a place is inside, or a corner is within so many metres of it.
    pub fn is_within(&self, place: [f64; 2], metres: f64) -> bool {
        let near = |p: &[f64; 2]| {
            let [x, y] = local_m(place, *p);
            x.hypot(y) < metres
        };
        self.rings.iter().flatten().any(near) || self.holds(place)
    }

    /// Distance of a place from the box around the polygon; 0 inside.
    fn box_m(&self, place: [f64; 2]) -> f64 {
        let [low, high] = self.corners;
        let [x, y] = local_m(place, [0, 1].map(|k| place[k].clamp(low[k], high[k])));
        x.hypot(y)
    }

    /// Distance of a place from the shore.
    fn shore_m(&self, place: [f64; 2]) -> f64 {
        let local = |p: [f64; 2]| local_m(place, p);
        self.edges().map(|[a, b]| from_origin_m(local(a), local(b))).fold(f64::INFINITY, f64::min)
    }
}

/// Distance of a place from any of the polygons; 0 inside.
pub fn distance_m(land: &[Polygon], place: [f64; 2]) -> f64 {
    land.iter().fold(f64::INFINITY, |least, p| match p {
        // Boxes are measured at one latitude: a tenth more covers the others.
        p if p.box_m(place) > 1.1 * least + 1.0 => least,
        p if p.holds(place) => 0.0,
        p => least.min(p.shore_m(place)),
    })
}

/// East and north of `place` from `origin`, nearby \[m\], on the ellipsoid's two radii of curvature.
pub fn local_m(origin: [f64; 2], place: [f64; 2]) -> [f64; 2] {
    let (a, e2) = (6_378_137.0, 0.006_694_379_990_14);
    let (sin, cos) = ((origin[1] + place[1]) / 2.0).to_radians().sin_cos();
    let w = 1.0 - e2 * sin * sin;
    let [east, north] = [0, 1].map(|k| (place[k] - origin[k]).to_radians());
    [east * cos * a / w.sqrt(), north * a * (1.0 - e2) / w.powf(1.5)]
}

/// Distance of the origin from the edge a–b.
fn from_origin_m(a: [f64; 2], b: [f64; 2]) -> f64 {
    let d = [b[0] - a[0], b[1] - a[1]];
    let square = d[0] * d[0] + d[1] * d[1];
    let along = if square > 0.0 { (-(a[0] * d[0] + a[1] * d[1]) / square).clamp(0.0, 1.0) } else { 0.0 };
    (a[0] + along * d[0]).hypot(a[1] + along * d[1])
}

/// The place `forward` and `starboard` metres from one with compass heading `psi`.
pub fn moved([lon, lat]: [f64; 2], psi: f64, [forward, starboard]: [f64; 2]) -> [f64; 2] {
    let east = forward * psi.sin() + starboard * psi.cos();
    let north = forward * psi.cos() - starboard * psi.sin();
    let [east_deg, north_deg] = [[1e-3, 0.0], [0.0, 1e-3]].map(|d| {
        let [x, y] = local_m([lon, lat], [lon + d[0], lat + d[1]]);
        1e-3 / x.hypot(y)
    });
    [lon + east * east_deg, lat + north * north_deg]
}

/// Easting and northing in a UTM zone of the northern half (Krüger's series to n³).
pub fn utm_m(zone: u32, [lon, lat]: [f64; 2]) -> [f64; 2] {
    let (a, f): (f64, f64) = (6_378_137.0, 1.0 / 298.257_223_563);
    let n = f / (2.0 - f);
    let radius = a / (1.0 + n) * (1.0 + n * n / 4.0 + n.powi(4) / 64.0);
    let series = [
        n / 2.0 - 2.0 * n * n / 3.0 + 5.0 * n.powi(3) / 16.0,
        13.0 * n * n / 48.0 - 3.0 * n.powi(3) / 5.0,
        61.0 * n.powi(3) / 240.0,
    ];
    let (phi, lambda) = (lat.to_radians(), (lon - (6.0 * f64::from(zone) - 183.0)).to_radians());
    let c = 2.0 * n.sqrt() / (1.0 + n);
    let t = (phi.sin().atanh() - c * (c * phi.sin()).atanh()).sinh();
    let (xi, eta) = (t.atan2(lambda.cos()), (lambda.sin() / t.hypot(lambda.cos())).asinh());
    let sum = |of: &dyn Fn(f64) -> f64| {
        series.iter().enumerate().map(|(j, s)| s * of(2.0 * (j as f64 + 1.0))).sum::<f64>()
    };
    let east = eta + sum(&|k| (k * xi).cos() * (k * eta).sinh());
    let north = xi + sum(&|k| (k * xi).sin() * (k * eta).cosh());
    [500_000.0 + 0.9996 * radius * east, 0.9996 * radius * north]
}

#[test]
fn law_the_tests_own_utm_keeps_angles_and_scale() {
    let [east, north] = utm_m(10, [-122.45, 47.27]);
    let central = utm_m(10, [-123.0, 0.0]);
    assert!((central[0] - 500_000.0).abs() < 1e-6 && central[1].abs() < 1e-6);
    // Scale on the central meridian: a degree of latitude at 47° N.
    let degree = utm_m(10, [-123.0, 47.5])[1] - utm_m(10, [-123.0, 46.5])[1];
    assert!((degree / 0.9996 - local_m([-123.0, 46.5], [-123.0, 47.5])[1]).abs() < 5.0, "{degree}");
    // Small steps keep their length but for the scale, and turn by the convergence only.
    let near = utm_m(10, [-122.449, 47.271]);
    let (a, b) = ([near[0] - east, near[1] - north], local_m([-122.45, 47.27], [-122.449, 47.271]));
    let scale = a[0].hypot(a[1]) / b[0].hypot(b[1]);
    assert!(
        (scale - 0.9996 - (east - 500_000.0).powi(2) / (2.0 * 6.38e6_f64.powi(2))).abs() < 1e-6,
        "{scale}"
    );
}
