//! The local plane and the coordinate reference systems against independent formulas.

use approx::assert_abs_diff_eq;
use chart::{Crs, Plane};
use proptest::prelude::*;

const A: f64 = 6_378_137.0;
const F: f64 = 1.0 / 298.257_223_563;

/// Vincenty's inverse formula (1975): distance [m] and azimuth [rad] at the first point.
fn vincenty(from: (f64, f64), to: (f64, f64)) -> (f64, f64) {
    let b = A * (1.0 - F);
    let reduced = |lat: f64| ((1.0 - F) * lat.to_radians().tan()).atan();
    let ((su1, cu1), (su2, cu2)) = (reduced(from.1).sin_cos(), reduced(to.1).sin_cos());
    let l = (to.0 - from.0).to_radians();
    let mut lambda = l;
    for _ in 0..200 {
        let (sl, cl) = lambda.sin_cos();
        let sin_sigma = (cu2 * sl).hypot(cu1 * su2 - su1 * cu2 * cl);
        let cos_sigma = su1 * su2 + cu1 * cu2 * cl;
        let sigma = sin_sigma.atan2(cos_sigma);
        let sin_alpha = cu1 * cu2 * sl / sin_sigma;
        let cos2_alpha = 1.0 - sin_alpha * sin_alpha;
        let cos_2sm = cos_sigma - 2.0 * su1 * su2 / cos2_alpha;
        let c = F / 16.0 * cos2_alpha * (4.0 + F * (4.0 - 3.0 * cos2_alpha));
        let inner = cos_2sm + c * cos_sigma * (2.0 * cos_2sm * cos_2sm - 1.0);
        let next = l + (1.0 - c) * F * sin_alpha * (sigma + c * sin_sigma * inner);
        if (next - lambda).abs() < 1e-15 {
            let u2 = cos2_alpha * (A * A - b * b) / (b * b);
            let k1 = ((1.0 + u2).sqrt() - 1.0) / ((1.0 + u2).sqrt() + 1.0);
            let (big_a, big_b) = ((1.0 + k1 * k1 / 4.0) / (1.0 - k1), k1 * (1.0 - 3.0 / 8.0 * k1 * k1));
            let third =
                big_b / 6.0 * cos_2sm * (4.0 * sin_sigma * sin_sigma - 3.0) * (4.0 * cos_2sm * cos_2sm - 3.0);
            let second = cos_sigma * (2.0 * cos_2sm * cos_2sm - 1.0) - third;
            let delta = big_b * sin_sigma * (cos_2sm + big_b / 4.0 * second);
            return (b * big_a * (sigma - delta), (cu2 * sl).atan2(cu1 * su2 - su1 * cu2 * cl));
        }
        lambda = next;
    }
    panic!("not converged");
}

#[test]
fn oracle_the_plane_is_vincentys_distance_and_azimuth() {
    let origin = (24.955, 60.105);
    let plane = Plane::new(origin.0, origin.1).unwrap();
    for (dx, dy) in [(0.1, 0.0), (0.0, 0.1), (-0.37, 0.21), (0.013, -0.44), (1.1, 0.9), (-2.0, -1.5)] {
        let to = (origin.0 + dx, origin.1 + dy);
        let (distance, azimuth) = vincenty(origin, to);
        let [x, y] = plane.to_plane(to.0, to.1);
        // Vincenty's series is good to about 0.1 mm.
        assert_abs_diff_eq!(x, distance * azimuth.sin(), epsilon = 2e-4);
        assert_abs_diff_eq!(y, distance * azimuth.cos(), epsilon = 2e-4);
    }
}

#[test]
fn oracle_a_meridian_arc_and_the_equator() {
    // A degree of longitude on the equator is a circle's; a meridian's first degree is 110 574.3886 m (WGS84).
    let plane = Plane::new(0.0, 0.0).unwrap();
    assert_abs_diff_eq!(plane.to_plane(1.0, 0.0)[0], A * 1f64.to_radians(), epsilon = 1e-6);
    assert_abs_diff_eq!(plane.to_plane(0.0, 1.0)[1], 110_574.388_6, epsilon = 1e-3);
}

#[test]
fn law_lengths_across_the_radius_grow_by_r2_over_6_r2() {
    let plane = Plane::new(24.955, 60.105).unwrap();
    for r in [10_000.0, 50_000.0, 100_000.0] {
        for direction in [0.3_f64, 1.9, 4.0] {
            let at = |angle: f64| plane.to_geographic([r * angle.sin(), r * angle.cos()]);
            let true_length = vincenty(at(direction), at(direction + 0.2)).0;
            let share = 2.0 * r * f64::sin(0.1) / true_length - 1.0;
            let expected = r * r / 6.0 / 6.38e6_f64.powi(2);
            assert_abs_diff_eq!(share, expected, epsilon = 0.03 * expected + 1e-8);
        }
    }
}

proptest! {
    #[test]
    fn law_the_plane_goes_there_and_back(
        lon in -180.0..180.0, lat in -80.0..80.0, x in -100_000.0..100_000.0, y in -100_000.0..100_000.0,
    ) {
        let plane = Plane::new(lon, lat).unwrap();
        let (there_lon, there_lat) = plane.to_geographic([x, y]);
        let back = plane.to_plane(there_lon, there_lat);
        prop_assert!((back[0] - x).hypot(back[1] - y) < 1e-6, "{back:?}");
    }

    #[test]
    fn law_crs_go_there_and_back(east in 300_000.0..700_000.0, north in 100_000.0..8_500_000.0) {
        for name in ["EPSG:32635", "EPSG:3067", "epsg:32735", "+proj=tmerc +lon_0=25 +x_0=500000 +ellps=GRS80"] {
            let crs = Crs::new(name).unwrap();
            let (lon, lat) = crs.to_geographic([east, north]).unwrap();
            let back = crs.to_own(lon, lat).unwrap();
            prop_assert!((back[0] - east).hypot(back[1] - north) < 1e-6, "{name} {back:?}");
        }
    }
}

/// Transverse Mercator by Krüger's series in n to the fourth order, as in Karney (2011), forward only.
fn utm(zone: f64, (lon, lat): (f64, f64)) -> [f64; 2] {
    let n = F / (2.0 - F);
    let radius = A / (1.0 + n) * (1.0 + n * n / 4.0 + n.powi(4) / 64.0);
    let alpha = [
        n / 2.0 - 2.0 / 3.0 * n.powi(2) + 5.0 / 16.0 * n.powi(3) + 41.0 / 180.0 * n.powi(4),
        13.0 / 48.0 * n.powi(2) - 3.0 / 5.0 * n.powi(3) + 557.0 / 1440.0 * n.powi(4),
        61.0 / 240.0 * n.powi(3) - 103.0 / 140.0 * n.powi(4),
        49_561.0 / 161_280.0 * n.powi(4),
    ];
    let e = (F * (2.0 - F)).sqrt();
    let tau = lat.to_radians().tan();
    let sigma = (e * (e * tau / tau.hypot(1.0)).atanh()).sinh();
    let tau1 = tau * sigma.hypot(1.0) - sigma * tau.hypot(1.0);
    let lambda = (lon - (6.0 * zone - 183.0)).to_radians();
    let xi1 = tau1.atan2(lambda.cos());
    let eta1 = (lambda.sin() / tau1.hypot(lambda.cos())).asinh();
    let (mut xi, mut eta) = (xi1, eta1);
    for (a, k) in alpha.iter().zip([2.0, 4.0, 6.0, 8.0]) {
        xi += a * f64::sin(k * xi1) * f64::cosh(k * eta1);
        eta += a * f64::cos(k * xi1) * f64::sinh(k * eta1);
    }
    [500_000.0 + 0.9996 * radius * eta, 0.9996 * radius * xi]
}

#[test]
fn oracle_utm_is_kruegers_series() {
    for (lon, lat) in [(24.955, 60.105), (27.0, 60.0), (22.1, 60.4), (25.0, 0.5)] {
        let own = Crs::new("EPSG:32635").unwrap().to_own(lon, lat).unwrap();
        let finnish = Crs::new("EPSG:3067").unwrap().to_own(lon, lat).unwrap();
        for k in 0..2 {
            assert_abs_diff_eq!(own[k], utm(35.0, (lon, lat))[k], epsilon = 1e-3);
            assert_abs_diff_eq!(finnish[k], own[k], epsilon = 1e-3);
        }
    }
    let own = Crs::new("EPSG:32610").unwrap().to_own(-122.43, 47.28).unwrap();
    assert_abs_diff_eq!(own[0], utm(10.0, (-122.43, 47.28))[0], epsilon = 1e-3);
    assert_abs_diff_eq!(own[1], utm(10.0, (-122.43, 47.28))[1], epsilon = 1e-3);
    // South of the equator UTM adds ten million metres.
    let south = Crs::new("EPSG:32735").unwrap().to_own(27.5, -20.0).unwrap();
    assert_abs_diff_eq!(south[1], 10_000_000.0 + utm(35.0, (27.5, -20.0))[1], epsilon = 1e-3);
}

/// `scripts/independent/crs.py`: what PROJ makes of places, by EPSG codes.
#[test]
fn oracle_systems_by_their_code_are_those_of_proj() {
    let rows: serde_json::Value =
        serde_json::from_str(&crate::support::fixture("../oracle/crs.json")).unwrap();
    for row in rows.as_array().unwrap() {
        let pair = |key: &str| [0, 1].map(|k: usize| row[key][k].as_f64().unwrap());
        let (crs, [lon, lat], expected) =
            (Crs::new(row["crs"].as_str().unwrap()).unwrap(), pair("place"), pair("own"));
        let found = crs.to_own(lon, lat).unwrap();
        let back = crs.to_geographic(expected).unwrap();
        for k in 0..2 {
            let near = if crs.is_geographic() { 1e-9 } else { 2e-3 };
            assert!((found[k] - expected[k]).abs() < near, "{row}: {found:?}");
            assert!(([back.0, back.1][k] - [lon, lat][k]).abs() < 1e-6, "{row}: {back:?}");
        }
    }
    assert!(rows.as_array().unwrap().len() > 15);
}

/// The geodesic from the origin is a straight line on the plane, so the meridian there turns as its azimuth does.
#[test]
fn oracle_true_north_turns_as_the_azimuth_of_the_geodesic() {
    use std::f64::consts::{PI, TAU};
    for (origin, place) in [
        ((25.0, 60.0), (25.4, 60.1)),
        ((15.0, 78.0), (15.6, 78.1)),
        ((179.95, -18.0), (-179.9, -18.2)),
        ((24.0, 86.0), (22.0, 86.2)),
        ((-70.0, 0.1), (-70.4, -0.3)),
    ] {
        let plane = Plane::new(origin.0, origin.1).unwrap();
        let (distance, out) = vincenty(origin, place);
        let (_, back) = vincenty(place, origin);
        let expected = (out - (back - PI) + PI).rem_euclid(TAU) - PI;
        let found = plane.north_rad(plane.to_plane(place.0, place.1));
        // The plane shears directions by as much as it stretches lengths.
        let sheared = distance * distance / (6.0 * A * A) + 1e-6;
        assert!((found - expected).abs() < sheared, "{origin:?} {place:?}: {found} {expected}");
    }
    assert_abs_diff_eq!(Plane::new(25.0, 60.0).unwrap().north_rad([0.0, 0.0]), 0.0, epsilon = 1e-12);
}

#[test]
fn geographic_crs_are_degrees_longitude_first() {
    for name in ["WGS84", "EPSG:4326", " wgs84 "] {
        let crs = Crs::new(name).unwrap();
        assert!(crs.is_geographic());
        let (lon, lat) = crs.to_geographic([24.9, 60.1]).unwrap();
        assert_abs_diff_eq!(lon, 24.9, epsilon = 1e-12);
        assert_abs_diff_eq!(lat, 60.1, epsilon = 1e-12);
    }
}

#[test]
fn unknown_crs_are_refused_naming_the_known() {
    for name in [
        "EPSG:9999999",
        "EPSG:99999",
        "ETRS",
        "",
        "+proj=nothing",
        "+proj=utm +zone=99",
        "+proj=longlat +nadgrids=file.gsb",
        "+proj=geocent",
        "EPSG:-1",
        "EPSG:",
    ] {
        let error = Crs::new(name).unwrap_err();
        assert!(error.to_string().contains("EPSG:3067"), "{error}");
        assert!(!error.to_string().contains('\n'));
    }
    let polar = Crs::new("EPSG:32635").unwrap();
    assert!(polar.to_geographic([f64::NAN, 0.0]).is_err());
    assert!(polar.to_own(f64::INFINITY, 60.0).is_err());
}

#[test]
fn origins_off_the_earth_are_refused() {
    for (lon, lat) in
        [(181.0, 0.0), (0.0, 90.5), (f64::NAN, 0.0), (0.0, f64::INFINITY), (6_650_000.0, 500_000.0)]
    {
        assert!(Plane::new(lon, lat).is_err(), "{lon} {lat}");
    }
}
