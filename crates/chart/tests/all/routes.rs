//! Route and track files, read back by readers of their own.

use chart::route::{Feature, Geometry, Route, Track, TrackPoint, Waypoint, geojson, gpx, rtz};

use crate::xml::{Element, read};

/// Names of an element's children, in order.
fn names(element: &Element) -> Vec<&str> {
    element.children.iter().map(|c| c.name.as_str()).collect()
}

fn route() -> Route {
    let waypoint = |id: u32, name: &str, lon_deg: f64, lat_deg: f64, t: f64| Waypoint {
        id,
        name: name.to_owned(),
        lon_deg,
        lat_deg,
        turn_radius_m: Some(185.2),
        speed_m_s: Some(1852.0 / 360.0),
        corridor_m: Some(92.6),
        t_s: Some(t),
        note: "zig-zag 20°/20° <n = 2>".to_owned(),
    };
    Route {
        name: "sea trial \"A&B\"".to_owned(),
        waypoints: vec![
            waypoint(3, "start", 24.912_345_678_9, 60.101_234_567_8, 0.0),
            waypoint(0, "", 24.95, 60.12, 1200.5),
            waypoint(7, "goal < home", -0.000_000_04, -60.12, 9000.0),
        ],
        departure_utc: Some("2026-12-31T23:59:00Z".to_owned()),
    }
}

/// Haversine on a sphere, to check a rule and not a length.
fn haversine_m(a: &Element, b: &Element) -> f64 {
    let rad = |e: &Element, key: &str| e.one("position").number(key).to_radians();
    let half = |d: f64| (d / 2.0).sin().powi(2);
    let h = half(rad(b, "lat") - rad(a, "lat"))
        + rad(a, "lat").cos() * rad(b, "lat").cos() * half(rad(b, "lon") - rad(a, "lon"));
    2.0 * 6_371_000.0 * h.sqrt().asin()
}

#[test]
fn rtz_keeps_the_rules_of_version_1_0() {
    let text = rtz(&route()).unwrap();
    assert!(text.starts_with("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<route "));
    let root = read(&text);
    assert_eq!((root.name.as_str(), root.get("version")), ("route", Some("1.0")));
    assert_eq!(root.get("xmlns"), Some("http://www.cirm.org/RTZ/1/0"));
    assert_eq!(names(&root), ["routeInfo", "waypoints", "schedules"]);
    assert_eq!(root.one("routeInfo").get("routeName"), Some("sea trial \"A&B\""));
    let waypoints = root.one("waypoints").all("waypoint");
    let ids: Vec<&str> = waypoints.iter().map(|w| w.get("id").unwrap()).collect();
    assert_eq!(ids, ["3", "0", "7"]);
    assert!(waypoints[0].all("leg").is_empty(), "no leg ends at the first");
    for (i, w) in waypoints.iter().enumerate() {
        let place = w.one("position");
        assert!(
            (-90.0..=90.0).contains(&place.number("lat")) && (-180.0..180.0).contains(&place.number("lon"))
        );
        assert!((place.number("lat") - route().waypoints[i].lat_deg).abs() < 1e-9);
        assert!((place.number("lon") - route().waypoints[i].lon_deg).abs() < 1e-9);
        assert_eq!(names(w)[0], "position", "the schema's order");
    }
    let (leg, inner) = (waypoints[1].one("leg"), waypoints[1]);
    assert!((inner.number("radius") - 0.1).abs() < 1e-6, "NM");
    assert!(
        (leg.number("speedMin") - 10.0).abs() < 1e-6 && leg.get("speedMin") == leg.get("speedMax"),
        "knots"
    );
    assert!(
        (leg.number("starboardXTD") - 0.05).abs() < 1e-6 && leg.get("portsideXTD") == leg.get("starboardXTD")
    );
    assert_eq!(leg.get("geometryType"), Some("Loxodrome"));
    assert_eq!(leg.get("legInfo"), Some("zig-zag 20°/20° <n = 2>"));
    let shortest = haversine_m(waypoints[0], waypoints[1]).min(haversine_m(waypoints[1], waypoints[2]));
    assert!(inner.number("radius") * 1852.0 < shortest / 2.0);
    assert_eq!((waypoints[0].get("radius"), waypoints[2].get("radius")), (None, None));
}

#[test]
fn rtz_schedules_only_with_a_departure() {
    let root = read(&rtz(&route()).unwrap());
    let manual = root.one("schedules").one("schedule").one("manual");
    let times: Vec<_> = manual
        .all("sheduleElement")
        .iter()
        .map(|e| (e.get("waypointId").unwrap().to_owned(), e.get("etd").or(e.get("eta")).unwrap().to_owned()))
        .collect();
    let expected =
        [("3", "2026-12-31T23:59:00Z"), ("0", "2027-01-01T00:19:00.500Z"), ("7", "2027-01-01T02:29:00Z")];
    assert_eq!(times, expected.map(|(a, b)| (a.to_owned(), b.to_owned())));
    let keys: Vec<bool> = manual.all("sheduleElement").iter().map(|e| e.get("etd").is_some()).collect();
    assert_eq!(keys, [true, false, false], "a departure, then arrivals");
    let without = Route { departure_utc: None, ..route() };
    assert!(read(&rtz(&without).unwrap()).all("schedules").is_empty());
}

#[test]
fn gpx_keeps_the_rules_of_version_1_1() {
    let points = (0..50).map(|i| TrackPoint {
        lon_deg: 24.9 + f64::from(i) * 1.234_567_8e-4,
        lat_deg: 60.1 - f64::from(i) * 2.345_678_9e-5,
        t_s: Some(f64::from(i)),
    });
    let track = Track { name: "planned & simulated".to_owned(), points: points.collect() };
    let root = read(&gpx(&route(), std::slice::from_ref(&track)).unwrap());
    assert_eq!((root.name.as_str(), root.get("version")), ("gpx", Some("1.1")));
    assert_eq!(root.get("xmlns"), Some("http://www.topografix.com/GPX/1/1"));
    assert!(root.get("creator").is_some_and(|c| !c.is_empty()));
    assert_eq!(names(&root), ["rte", "trk"], "the schema's order");
    let rte = root.one("rte");
    assert_eq!(rte.one("name").text, "sea trial \"A&B\"");
    assert_eq!(rte.all("rtept").len(), 3);
    assert_eq!(names(rte.all("rtept")[1]), ["time", "name", "desc"], "the schema's order");
    assert_eq!(rte.all("rtept")[2].one("name").text, "goal < home");
    let written = root.one("trk").one("trkseg").all("trkpt");
    assert_eq!(written.len(), track.points.len());
    for (element, point) in written.iter().zip(&track.points) {
        assert!((element.number("lat") - point.lat_deg).abs() < 1e-9);
        assert!((element.number("lon") - point.lon_deg).abs() < 1e-9);
    }
    assert_eq!(written[49].one("time").text, "2026-12-31T23:59:49Z");
    let without = Route { departure_utc: None, ..route() };
    assert!(!gpx(&without, &[track]).unwrap().contains("<time>"));
}

#[test]
fn the_antimeridian_is_written_as_minus_180() {
    let mut route = route();
    route.waypoints[2].lon_deg = 180.0;
    for text in [rtz(&route).unwrap(), gpx(&route, &[]).unwrap()] {
        assert!(text.contains("lon=\"-180\"") && !text.contains("lon=\"180\""), "{text}");
    }
}

#[test]
fn geojson_is_read_back_with_numbers_and_directions() {
    let properties = |step: u32| {
        let value = serde_json::json!({ "step": step, "maneuver": "zig-zag", "t_s": 12.5 });
        value.as_object().cloned().unwrap()
    };
    let line: Vec<[f64; 2]> =
        (0..20).map(|i| [24.9 + f64::from(i) * 1.111_111_1e-5, 60.1 + f64::from(i) * 0.777_777e-5]).collect();
    let clockwise = vec![[0.0, 0.0], [0.0, 1.0], [1.0, 1.0], [1.0, 0.0]];
    let hole = vec![[0.2, 0.2], [0.4, 0.2], [0.4, 0.4], [0.2, 0.2]];
    let features = [
        Feature { geometry: Geometry::Line(line.clone()), properties: properties(0) },
        Feature { geometry: Geometry::Point([24.9, 60.1]), properties: properties(1) },
        Feature { geometry: Geometry::Polygon(vec![clockwise, hole]), properties: properties(2) },
    ];
    let text = geojson(&features).unwrap();
    let read = text.parse::<::geojson::FeatureCollection>().unwrap();
    assert!(read.foreign_members.is_none(), "no crs member");
    assert_eq!(read.features.len(), 3);
    for (k, f) in read.features.iter().enumerate() {
        assert_eq!(f.properties.as_ref().unwrap()["step"], k);
    }
    let ::geojson::GeometryValue::LineString { coordinates } =
        &read.features[0].geometry.as_ref().unwrap().value
    else {
        panic!("a line")
    };
    for (p, q) in coordinates.iter().zip(&line) {
        assert!((p[0] - q[0]).abs() < 1e-9 && (p[1] - q[1]).abs() < 1e-9);
    }
    let ::geojson::GeometryValue::Polygon { coordinates } =
        &read.features[2].geometry.as_ref().unwrap().value
    else {
        panic!("a polygon")
    };
    let area = |ring: &[::geojson::Position]| -> f64 {
        ring.windows(2).map(|w| w[0][0] * w[1][1] - w[1][0] * w[0][1]).sum()
    };
    assert!(coordinates.iter().all(|r| r.first() == r.last()));
    assert_eq!(coordinates.iter().map(Vec::len).collect::<Vec<_>>(), [5, 4]);
    assert!(area(&coordinates[0]) > 0.0 && area(&coordinates[1]) < 0.0, "right-hand rule");
}

#[test]
fn routes_that_break_the_rules_are_refused() {
    type Break = fn(&mut Route);
    let broken: [(&str, Break); 11] = [
        ("id 3 twice", |r| r.waypoints[1].id = 3),
        ("half the shortest", |r| r.waypoints[1].turn_radius_m = Some(1500.0)),
        ("turn radius", |r| r.waypoints[1].turn_radius_m = Some(-1.0)),
        ("speed", |r| r.waypoints[1].speed_m_s = Some(f64::NAN)),
        ("longitude", |r| r.waypoints[1].lon_deg = 385_000.0),
        ("longitude", |r| r.waypoints[1].lat_deg = f64::NAN),
        ("at least two", |r| r.waypoints.truncate(1)),
        ("time", |r| r.waypoints[1].t_s = Some(9001.0)),
        ("departure", |r| r.departure_utc = Some("tomorrow".to_owned())),
        ("one line", |r| r.waypoints[1].name = "a\u{1}b".to_owned()),
        ("one line", |r| r.name = "a\nb".to_owned()),
    ];
    for (expected, change) in broken {
        let mut route = route();
        change(&mut route);
        for error in [rtz(&route).unwrap_err(), gpx(&route, &[]).unwrap_err()] {
            assert!(error.to_string().contains(expected), "{expected}: {error}");
        }
    }
    let mut wide = route();
    wide.waypoints[2].corridor_m = Some(20_000.0);
    assert!(rtz(&wide).unwrap_err().to_string().contains("10 NM"));
}

#[test]
fn radii_are_lowered_to_fit() {
    let mut route = route();
    for waypoint in &mut route.waypoints {
        waypoint.turn_radius_m = Some(1e6);
    }
    assert!(rtz(&route).is_err());
    assert_eq!(route.fit_radii(), 2, "the last leg is long");
    assert!((route.waypoints[1].turn_radius_m.unwrap() - 0.49 * route.leg_m(0).unwrap()).abs() < 1e-9);
    assert!(rtz(&route).is_ok());
    assert_eq!(route.fit_radii(), 0);
    assert_eq!(route.leg_m(2), None);
}

#[test]
fn geometries_that_break_the_rules_are_refused() {
    let one = |geometry: Geometry| geojson(&[Feature { geometry, properties: serde_json::Map::new() }]);
    assert!(one(Geometry::Point([181.0, 0.0])).is_err());
    assert!(one(Geometry::Point([f64::NAN, 0.0])).is_err());
    assert!(one(Geometry::Line(vec![[0.0, 0.0]])).is_err());
    assert!(one(Geometry::Line(vec![[179.9, 0.0], [-179.9, 0.0]])).unwrap_err().to_string().contains("180"));
    assert!(one(Geometry::Polygon(vec![])).is_err());
    assert!(one(Geometry::Polygon(vec![vec![[0.0, 0.0], [1.0, 1.0]]])).is_err());
    assert!(one(Geometry::Polygon(vec![vec![]])).is_err());
}
