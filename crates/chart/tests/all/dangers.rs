//! The nearest danger, the least depth along a track, and what closes places.

use chart::{Bounds, Causes, Chart, Layer, LayerKind, Plane, PolygonLayer};

use crate::support::from_segment;

/// Squares of `half` degrees around places, each with a name and a depth.
fn squares(all: &[([f64; 2], f64, f64)]) -> String {
    let features: Vec<String> = all
        .iter()
        .enumerate()
        .map(|(k, ([x, y], half, depth))| {
            let corner = |dx: f64, dy: f64| format!("[{}, {}]", x + dx * half, y + dy * half);
            let ring = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0)]
                .map(|(dx, dy)| corner(dx, dy));
            format!(
                r#"{{"type": "Feature", "properties": {{"name": "s{k}", "least": {depth}}},
                "geometry": {{"type": "Polygon", "coordinates": [[{}]]}}}}"#,
                ring.join(", ")
            )
        })
        .collect();
    format!(r#"{{"type": "FeatureCollection", "features": [{}]}}"#, features.join(", "))
}

#[test]
fn law_the_nearest_danger_is_that_of_all_edges_and_depths_are_the_least() {
    let plane = Plane::new(25.0, 60.0).unwrap();
    let area = Bounds::new([-9000.0, -9000.0], [9000.0, 9000.0]).unwrap();
    let water = ([25.0, 60.0], 0.05, 20.0);
    let shoals: Vec<([f64; 2], f64, f64)> = (0..40)
        .map(|k| {
            let (a, b) = (f64::from(k * 37 % 40), f64::from(k * 11 % 40));
            ([24.96 + 0.002 * a, 59.96 + 0.002 * b], 0.0006, if k % 2 == 0 { 3.0 } else { 7.0 })
        })
        .collect();
    let all: Vec<_> = std::iter::once(water).chain(shoals.iter().copied()).collect();
    let kind = LayerKind::Depth { least: "least".to_owned() };
    let layer = PolygonLayer::from_geojson(&squares(&all), &kind, None).unwrap();
    let chart = Chart::new(plane, area, &[Layer::Polygons(layer)], None).unwrap();
    let dangers = chart.dangers(5.0);
    let mut over_shoals = 0;
    for k in 0..400 {
        let start = [f64::from(k % 20) * 150.0 - 1500.0, f64::from(k / 20) * 250.0 - 1250.0];
        let track: Vec<[f64; 2]> = (0..4).map(|i| [start[0] + 40.0 * f64::from(i), start[1]]).collect();
        let gap = |([x, y], half, _): &([f64; 2], f64, f64)| {
            let corner = |dx: f64, dy: f64| plane.to_plane(x + dx * half, y + dy * half);
            let ring = [corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)];
            let inside = |p: &[f64; 2]| {
                p[0] > ring[0][0] && p[0] < ring[1][0] && p[1] > ring[0][1] && p[1] < ring[2][1]
            };
            let edges = |p: &[f64; 2]| {
                (0..4).map(|i| from_segment(*p, ring[i], ring[(i + 1) % 4])).fold(f64::INFINITY, f64::min)
            };
            track.iter().map(|p| if inside(p) { 0.0 } else { edges(p) }).fold(f64::INFINITY, f64::min)
        };
        let expected = shoals.iter().filter(|own| own.2 < 5.0).map(gap).fold(f64::INFINITY, f64::min);
        let found = dangers.nearest(&track).unwrap();
        assert!((found.distance_m - expected).abs() < 0.05, "{found:?}, {expected}");
        let [from, to] = found.between;
        let apart = (to[0] - from[0]).hypot(to[1] - from[1]);
        assert!(track.contains(&from) && (apart - found.distance_m).abs() < 1e-6, "{found:?}");
        let own: usize = found.called.name.as_deref().unwrap()[1..].parse().unwrap();
        assert!((gap(&all[own]) - expected).abs() < 0.05 && found.called.to_string().ends_with(" 3 m"));
        let over: Vec<f64> = all.iter().filter(|own| gap(own) == 0.0).map(|own| own.2).collect();
        let least = over.iter().copied().reduce(f64::min);
        assert_eq!(chart.least_depth_m(&track), least);
        over_shoals += usize::from(over.len() > 1);
    }
    assert!(over_shoals > 5, "some tracks cross a shoal: {over_shoals}");
}

#[test]
fn the_edge_of_what_is_charted_is_a_danger() {
    let plane = Plane::new(25.0, 60.0).unwrap();
    let area = Bounds::new([-9000.0, -9000.0], [9000.0, 9000.0]).unwrap();
    let kind = LayerKind::Depth { least: "least".to_owned() };
    let layer = PolygonLayer::from_geojson(&squares(&[([25.0, 60.0], 0.01, 20.0)]), &kind, None).unwrap();
    let chart = Chart::new(plane, area, &[Layer::Polygons(layer)], None).unwrap();
    let north = plane.to_plane(25.0, 60.01)[1];
    let found = chart.dangers(5.0).nearest(&[[0.0, north - 100.0]]).unwrap();
    assert_eq!(found.called.to_string(), "edge of the charted area");
    assert!((found.distance_m - 100.0).abs() < 0.5, "{found:?}");
    assert!((found.between[1][1] - north).abs() < 0.5 && found.between[1][0].abs() < 0.5, "{found:?}");
    assert_eq!(chart.dangers(5.0).nearest(&[]), None);
}

#[test]
fn law_places_are_closed_by_what_comes_within_a_distance_of_them() {
    let plane = Plane::new(25.0, 60.0).unwrap();
    let area = Bounds::new([-9000.0, -9000.0], [9000.0, 9000.0]).unwrap();
    let all = [([25.0, 60.0], 0.06, 20.0), ([25.0, 60.0], 0.004, 3.0), ([25.01, 60.0], 0.002, 4.0)];
    let kind = LayerKind::Depth { least: "least".to_owned() };
    let layer = PolygonLayer::from_geojson(&squares(&all), &kind, None).unwrap();
    let chart = Chart::new(plane, area, &[Layer::Polygons(layer)], None).unwrap();
    let places: Vec<[f64; 2]> =
        (0..900).map(|k| [f64::from(k % 30) * 100.0 - 1500.0, f64::from(k / 30) * 100.0 - 1500.0]).collect();
    // East and north half widths of a square on the plane, which is nearly one of degrees here.
    let gap = |p: [f64; 2], ([x, y], half, _): ([f64; 2], f64, f64)| {
        let [low, high] = [-half, half].map(|d| plane.to_plane(x + d, y + d));
        [0, 1].map(|k| (low[k] - p[k]).max(p[k] - high[k]).max(0.0))
    };
    let near = |k: usize, within: f64| {
        places
            .iter()
            .filter(|p| {
                let [a, b] = gap(**p, all[k]);
                a.hypot(b) < within
            })
            .count()
    };
    let found = chart.dangers(5.0).closing(&places, 100.0);
    let told: Vec<(String, Causes, usize)> =
        found.iter().map(|own| (own.called.to_string(), own.cause, own.places)).collect();
    let [first, second] = [near(1, 100.0), near(2, 100.0)];
    assert!(first > second && second > 20, "{first}, {second}");
    let expected = ["water s1 3 m", "water s2 4 m"];
    assert_eq!(told.len(), 2, "{told:?}");
    for ((name, cause, count), (wanted, places)) in told.iter().zip(expected.iter().zip([first, second])) {
        assert_eq!((name.as_str(), *cause), (*wanted, Causes::SHOAL));
        // Sides of the squares on the plane are off by less than a metre.
        assert!(count.abs_diff(places) <= 2, "{name}: {count}, {places}");
    }
    assert!(found.iter().all(|own| own.rule().is_none()));
    // Beyond the charted square nothing is known.
    let far = chart.dangers(5.0).closing(&[[0.0, 8000.0], [0.0, 1500.0]], 100.0);
    assert_eq!(
        (far.len(), far[0].called.what, far[0].cause, far[0].places),
        (1, "uncharted water", Causes::UNCHARTED, 1)
    );
}
