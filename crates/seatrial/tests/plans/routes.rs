//! Routes and tracks for others, read back by readers that are not ours.

use geojson::{FeatureCollection, GeometryValue};

use crate::geometry::local_m;
use crate::planned::*;
use crate::xml::{Element, read};

fn all() -> [&'static Planned; 3] {
    let [eight, four] = helsinki_planned();
    [eight, four, small_planned()]
}

fn near(a: [f64; 2], b: [f64; 2]) -> bool {
    (0..2).all(|k| (a[k] - b[k]).abs() < 1e-6)
}

fn place(element: &Element) -> [f64; 2] {
    [element.number("lon"), element.number("lat")]
}

fn metres(a: [f64; 2], b: [f64; 2]) -> f64 {
    let [x, y] = local_m(a, b);
    x.hypot(y)
}

/// The nodes of the plan, without repetition, and where the track ends.
fn waypoints(planned: &Planned) -> Vec<[f64; 2]> {
    let number = |leg: &serde_json::Value, key: &str| leg[key].as_f64().unwrap();
    let nodes = planned.legs().iter().map(|l| [number(l, "longitude_deg"), number(l, "latitude_deg")]);
    let mut places: Vec<[f64; 2]> = nodes.collect();
    places.dedup_by(|a, b| metres(*a, *b) < 1.0);
    let end = *planned.track.place.last().unwrap();
    if metres(places[places.len() - 1], end) >= 1.0 {
        places.push(end);
    }
    places
}

#[test]
fn the_rtz_route_keeps_the_rules_of_version_1_0_and_passes_the_nodes() {
    for planned in all() {
        let root = read(planned.text("route.rtz"));
        assert_eq!((root.name.as_str(), root.get("version")), ("route", Some("1.0")));
        assert_eq!(root.get("xmlns"), Some("http://www.cirm.org/RTZ/1/0"));
        assert!(root.one("routeInfo").get("routeName").is_some_and(|name| !name.is_empty()));
        let points = root.one("waypoints").all("waypoint");
        let mut ids: Vec<u32> = points.iter().map(|p| p.get("id").unwrap().parse().unwrap()).collect();
        ids.sort_unstable();
        ids.dedup();
        assert_eq!(ids.len(), points.len(), "ids are unique");
        let places: Vec<[f64; 2]> = points.iter().map(|p| place(p.one("position"))).collect();
        let expected = waypoints(planned);
        assert_eq!(places.len(), expected.len());
        assert!(places.iter().zip(&expected).all(|(a, b)| near(*a, *b)), "{places:?} {expected:?}");
        assert_eq!(points[0].all("leg").len(), 0, "no leg ends at the first waypoint");
        for (k, point) in points.iter().enumerate().skip(1) {
            assert!(point.one("leg").number("speedMax") > 0.0);
            let adjacent = places[k - 1..].windows(2).take(2).map(|pair| metres(pair[0], pair[1]));
            let shortest = adjacent.fold(f64::INFINITY, f64::min);
            if let Some(radius) = point.get("radius") {
                let radius = 1852.0 * radius.parse::<f64>().unwrap();
                assert!(radius > 0.0 && radius < shortest / 2.0, "waypoint {k}: {radius} of {shortest}");
            }
        }
    }
}

#[test]
fn the_gpx_file_has_the_routes_waypoints_and_the_tracks_samples() {
    for planned in all() {
        let root = read(planned.text("route.gpx"));
        assert_eq!(root.get("xmlns"), Some("http://www.topografix.com/GPX/1/1"));
        assert_eq!(root.get("version"), Some("1.1"));
        let route: Vec<[f64; 2]> = root.one("rte").all("rtept").into_iter().map(place).collect();
        let expected = waypoints(planned);
        assert_eq!(route.len(), expected.len());
        assert!(route.iter().zip(&expected).all(|(a, b)| near(*a, *b)));
        let track: Vec<[f64; 2]> =
            root.one("trk").one("trkseg").all("trkpt").into_iter().map(place).collect();
        assert_eq!(track.len(), planned.track.place.len());
        assert!(track.iter().zip(&planned.track.place).all(|(a, b)| near(*a, *b)));
    }
}

#[test]
fn the_geojson_track_has_a_line_per_leg_that_joins_the_next() {
    for planned in all() {
        let file: FeatureCollection = planned.text("track.geojson").parse().unwrap();
        let (mut lines, mut named) = (Vec::new(), Vec::new());
        for feature in &file.features {
            let own = feature.properties.as_ref().unwrap();
            match &feature.geometry.as_ref().unwrap().value {
                GeometryValue::LineString { coordinates } => {
                    let line: Vec<[f64; 2]> = coordinates.iter().map(|p| [p[0], p[1]]).collect();
                    lines.push((own, line));
                }
                GeometryValue::Point { coordinates } => {
                    named.push((own["name"].as_str().unwrap(), [coordinates[0], coordinates[1]]));
                }
                other => panic!("{other:?}"),
            }
        }
        let track = &planned.track;
        assert_eq!(named.iter().map(|n| n.0).collect::<Vec<_>>(), ["start", "goal"]);
        assert!(near(named[0].1, track.place[0]) && near(named[1].1, *track.place.last().unwrap()));
        assert_eq!(lines.len(), planned.legs().len());
        for (k, ((own, line), rows)) in lines.iter().zip(track.starts().windows(2)).enumerate() {
            assert_eq!(own["step"], k + 1);
            assert_eq!(own["action"], planned.steps()[k]["action"]);
            assert_eq!(own["start_s"], planned.legs()[k]["start_s"]);
            let sailed = &track.place[rows[0]..=rows[1]];
            assert_eq!(line.len(), sailed.len());
            assert!(line.iter().zip(sailed).all(|(a, b)| near(*a, *b)), "leg {k}");
        }
    }
}

#[test]
fn the_map_is_an_svg_that_names_its_maneuvers() {
    for planned in all() {
        let root = read(planned.text("map.svg"));
        assert_eq!(root.name, "svg");
        for name in planned.plan["counts"].as_object().unwrap().keys() {
            assert!(planned.text("map.svg").contains(name.as_str()), "{name}");
        }
        assert!(!planned.text("map.svg").contains("NaN"));
    }
}
