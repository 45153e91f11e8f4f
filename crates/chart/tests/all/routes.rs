//! Route and track files, read back by readers of their own.

use chart::route::{Feature, Geometry, Route, Timestamp, Track, Waypoint, geojson, gpx, qgroundcontrol, rtz};
use geographiclib_rs::{DirectGeodesic, Geodesic};

use crate::xml::{Element, read};

/// Names of an element's children, in order.
fn names(element: &Element) -> Vec<&str> {
    element.children.iter().map(|c| c.name.as_str()).collect()
}

fn route() -> Route {
    let waypoint = |id: u32, name: &str, lon_deg: f64, lat_deg: f64| Waypoint {
        id,
        name: name.to_owned(),
        lon_deg,
        lat_deg,
        turn_radius_m: Some(185.2),
        speed_m_s: Some(1852.0 / 360.0),
        xtd_m: Some([18.52, 37.04]),
        time_s: None,
        leave_s: None,
        note: "zig-zag 20°/20° <n = 2>".to_owned(),
    };
    Route {
        name: "sea trial \"A&B\"".to_owned(),
        departure: None,
        waypoints: vec![
            waypoint(3, "start", 24.912_345_678_9, 60.101_234_567_8),
            waypoint(0, "", 24.95, 60.12),
            waypoint(7, "goal < home", -0.000_000_04, -60.12),
        ],
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
    assert_eq!(names(&root), ["routeInfo", "waypoints"]);
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
    assert_eq!(leg.get("geometryType"), Some("Loxodrome"));
    assert!((leg.number("portsideXTD") - 0.01).abs() < 1e-9, "NM");
    assert!((leg.number("starboardXTD") - 0.02).abs() < 1e-9, "NM");
    assert_eq!(leg.get("legInfo"), Some("zig-zag 20°/20° <n = 2>"));
    let shortest = haversine_m(waypoints[0], waypoints[1]).min(haversine_m(waypoints[1], waypoints[2]));
    assert!(inner.number("radius") * 1852.0 < shortest / 2.0);
    assert_eq!((waypoints[0].get("radius"), waypoints[2].get("radius")), (None, None));
}

#[test]
fn gpx_keeps_the_rules_of_version_1_1() {
    let points =
        (0..50).map(|i| [24.9 + f64::from(i) * 1.234_567_8e-4, 60.1 - f64::from(i) * 2.345_678_9e-5]);
    let track =
        Track { name: "planned & simulated".to_owned(), points: points.collect(), clock_s: [0.0, 0.5] };
    let root = read(&gpx(&[&route()], std::slice::from_ref(&track)).unwrap());
    assert_eq!((root.name.as_str(), root.get("version")), ("gpx", Some("1.1")));
    assert_eq!(root.get("xmlns"), Some("http://www.topografix.com/GPX/1/1"));
    assert!(root.get("creator").is_some_and(|c| !c.is_empty()));
    assert_eq!(names(&root), ["rte", "trk"], "the schema's order");
    let rte = root.one("rte");
    assert_eq!(rte.one("name").text, "sea trial \"A&B\"");
    assert_eq!(rte.all("rtept").len(), 3);
    assert_eq!(names(rte.all("rtept")[1]), ["name", "cmt", "desc", "extensions"], "the schema's order");
    let by_opencpn = rte.all("rtept")[1].one("extensions").one("opencpn:rte_properties");
    assert!((by_opencpn.number("planned_speed") - 10.0).abs() < 1e-6, "knots");
    assert_eq!(root.get("xmlns:opencpn"), Some("http://www.opencpn.org"));
    assert_eq!(rte.all("rtept")[1].one("cmt").text, "10.0 kn on the leg to here");
    assert_eq!(rte.all("rtept")[2].one("name").text, "goal < home");
    let written = root.one("trk").one("trkseg").all("trkpt");
    assert_eq!(written.len(), track.points.len());
    for (element, point) in written.iter().zip(&track.points) {
        assert!((element.number("lon") - point[0]).abs() < 1e-9);
        assert!((element.number("lat") - point[1]).abs() < 1e-9);
    }
}

/// [`route`] that begins at eight in the morning and lasts an hour and a bit.
fn timed() -> Route {
    let mut route = route();
    route.departure = Some("2026-06-01T11:00:00+03:00".parse::<Timestamp>().unwrap());
    for (waypoint, time_s) in route.waypoints.iter_mut().zip([0.0, 90.4, 3725.0]) {
        waypoint.time_s = Some(time_s);
    }
    route.waypoints[2].leave_s = Some(4200.0);
    route
}

#[test]
fn rtz_tells_the_times_of_a_departure() {
    assert!(!rtz(&route()).unwrap().contains("2026"), "no times without a departure");
    let root = read(&rtz(&timed()).unwrap());
    assert_eq!(names(&root), ["routeInfo", "waypoints", "schedules"], "the schema's order");
    let schedule = root.one("schedules").one("schedule");
    assert_eq!((schedule.get("id"), names(schedule)), (Some("1"), vec!["manual", "calculated"]));
    let begin = schedule.one("manual").all("sheduleElement");
    assert_eq!((begin.len(), begin[0].get("etd")), (1, Some("2026-06-01T08:00:00Z")));
    let all = schedule.one("calculated").all("sheduleElement");
    let ids: Vec<&str> = all.iter().map(|e| e.get("waypointId").unwrap()).collect();
    assert_eq!(ids, ["3", "0", "7"]);
    assert_eq!(all[1].get("eta"), Some("2026-06-01T08:01:30Z"));
    assert_eq!(all[2].get("eta"), Some("2026-06-01T09:02:05Z"));
    assert!((all[1].number("speed") - 10.0).abs() < 1e-6, "knots");
    assert_eq!((all[1].get("etd"), all[2].get("etd")), (None, Some("2026-06-01T09:10:00Z")));
}

#[test]
fn gpx_tells_the_times_of_a_departure() {
    let points = vec![[24.9, 60.1], [24.91, 60.1], [24.92, 60.1]];
    let track = Track { name: "zig-zag".to_owned(), points, clock_s: [60.0, 0.5] };
    let root = read(&gpx(&[&timed()], &[track]).unwrap());
    let route = root.one("rte").all("rtept");
    let departure = &root.one("rte").one("extensions").one("opencpn:planned_departure").text;
    assert_eq!((names(root.one("rte"))[1], departure.as_str()), ("extensions", "2026-06-01T08:00:00Z"));
    let leaves = route[2].one("extensions").one("opencpn:rte_properties").get("etd");
    assert_eq!(leaves, Some("2026-06-01T09:10:00"));
    assert_eq!(names(route[1]), ["time", "name", "cmt", "desc", "extensions"], "the schema's order");
    assert_eq!(route[1].one("cmt").text, "10.0 kn on the leg to here");
    assert_eq!(route[2].one("time").text, "2026-06-01T09:02:05Z");
    let times: Vec<&str> =
        root.one("trk").one("trkseg").all("trkpt").iter().map(|p| p.one("time").text.as_str()).collect();
    assert_eq!(times, ["2026-06-01T08:01:00Z", "2026-06-01T08:01:00.5Z", "2026-06-01T08:01:01Z"]);
}

#[test]
fn a_ground_stations_plan_goes_to_every_waypoint_at_its_speed() {
    let plan: serde_json::Value = serde_json::from_str(&qgroundcontrol(&route()).unwrap()).unwrap();
    assert_eq!((&plan["fileType"], &plan["version"]), (&"Plan".into(), &1.into()));
    let items = plan["mission"]["items"].as_array().unwrap();
    assert!(items.iter().enumerate().all(|(i, item)| item["doJumpId"] == i + 1));
    let places: Vec<[f64; 2]> = items
        .iter()
        .filter(|item| item["command"] == 16)
        .map(|item| [5, 4].map(|k: usize| item["params"][k].as_f64().unwrap()))
        .collect();
    let expected: Vec<[f64; 2]> = route().waypoints.iter().map(|w| [w.lon_deg, w.lat_deg]).collect();
    assert_eq!(places, expected);
    let speeds: Vec<&serde_json::Value> = items.iter().filter(|item| item["command"] == 178).collect();
    assert_eq!(speeds.len(), 1, "said once where it stays");
    assert_eq!(speeds[0]["params"][1].as_f64(), route().waypoints[1].speed_m_s);
}

#[test]
fn law_a_course_that_is_held_leads_to_the_next_waypoint() {
    let from = Waypoint { lon_deg: 24.9, lat_deg: 60.1, ..Waypoint::default() };
    for (east, north) in [(0.2, 0.1), (-0.3, 0.05), (0.1, -0.2), (-0.1, -0.1), (0.3, 0.0), (0.0, 0.2)] {
        let to = Waypoint { id: 1, lon_deg: 24.9 + east, lat_deg: 60.1 + north, ..Waypoint::default() };
        let (east, goal) = (east, to.clone());
        let route = Route { waypoints: vec![from.clone(), to], ..Route::default() };
        let course = route.course_deg(0).unwrap();
        // Small steps along geodesics that begin on the course.
        let (mut lat, mut lon, earth) = (from.lat_deg, from.lon_deg, Geodesic::wgs84());
        let steps = 2000;
        for _ in 0..steps {
            (lat, lon) = earth.direct(lat, lon, course, route.leg_m(0).unwrap() / f64::from(steps));
        }
        // The loxodrome is longer than the geodesic by less than this.
        assert!(
            (lat - goal.lat_deg).abs() < 2e-5 && (lon - goal.lon_deg).abs() < 4e-5,
            "{east}: {lat} {lon}"
        );
    }
    assert_eq!(Route::default().course_deg(0), None);
}

#[test]
fn the_antimeridian_is_written_as_minus_180() {
    let mut route = route();
    route.waypoints[2].lon_deg = 180.0;
    for text in [rtz(&route).unwrap(), gpx(&[&route], &[]).unwrap()] {
        assert!(text.contains("lon=\"-180\"") && !text.contains("lon=\"180\""), "{text}");
    }
}

#[test]
fn geojson_is_read_back() {
    let properties = |step: u32| {
        let value = serde_json::json!({ "step": step, "maneuver": "zig-zag", "t_s": 12.5 });
        value.as_object().cloned().unwrap()
    };
    let line: Vec<[f64; 2]> =
        (0..20).map(|i| [24.9 + f64::from(i) * 1.111_111_1e-5, 60.1 + f64::from(i) * 0.777_777e-5]).collect();
    let features = [
        Feature { geometry: Geometry::Line(line.clone()), properties: properties(0) },
        Feature { geometry: Geometry::Point([24.9, 60.1]), properties: properties(1) },
    ];
    let text = geojson(&features).unwrap();
    let read = text.parse::<::geojson::FeatureCollection>().unwrap();
    assert!(read.foreign_members.is_none(), "no crs member");
    assert_eq!(read.features.len(), 2);
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
}

#[test]
fn a_line_across_the_antimeridian_is_cut_there() {
    let line = vec![[179.9, 1.0], [-179.7, 2.0], [-179.9, 3.0], [180.0, 4.0], [-179.9, 5.0]];
    let text =
        geojson(&[Feature { geometry: Geometry::Line(line), properties: serde_json::Map::new() }]).unwrap();
    let read: serde_json::Value = serde_json::from_str(&text).unwrap();
    let geometry = &read["features"][0]["geometry"];
    assert_eq!(geometry["type"], "MultiLineString");
    let parts: Vec<Vec<[f64; 2]>> = serde_json::from_value(geometry["coordinates"].clone()).unwrap();
    assert_eq!(parts[0], [[179.9, 1.0], [180.0, 1.25]]);
    assert_eq!(parts[1][..3], [[-180.0, 1.25], [-179.7, 2.0], [-179.9, 3.0]]);
    assert!(
        parts.iter().flat_map(|part| part.windows(2)).all(|w| (w[0][0] - w[1][0]).abs() < 1.0),
        "{parts:?}"
    );
    let last = parts.last().unwrap().last().unwrap();
    assert_eq!(*last, [-179.9, 5.0]);
}

#[test]
fn a_corridor_that_rtz_cannot_tell_is_left_out() {
    let mut route = route();
    route.waypoints.iter_mut().for_each(|own| own.xtd_m = Some([1.0, 18_519.0]));
    assert!(rtz(&route).unwrap().contains("starboardXTD"));
    route.waypoints.iter_mut().for_each(|own| own.xtd_m = Some([1.0, 18_521.0]));
    assert!(!rtz(&route).unwrap().contains("XTD"));
}

#[test]
fn routes_that_break_the_rules_are_refused() {
    type Break = fn(&mut Route);
    let broken: [(&str, Break); 11] = [
        ("XTD", |r| r.waypoints[1].xtd_m = Some([10.0, -1.0])),
        ("5 s or more, the time of waypoint 3", |r| {
            (r.waypoints[0].time_s, r.waypoints[1].time_s) = (Some(5.0), Some(4.0));
        }),
        ("id 3 twice", |r| r.waypoints[1].id = 3),
        ("half the shortest", |r| r.waypoints[1].turn_radius_m = Some(1500.0)),
        ("turn radius", |r| r.waypoints[1].turn_radius_m = Some(-1.0)),
        ("speed", |r| r.waypoints[1].speed_m_s = Some(f64::NAN)),
        ("longitude", |r| r.waypoints[1].lon_deg = 385_000.0),
        ("longitude", |r| r.waypoints[1].lat_deg = f64::NAN),
        ("at least two", |r| r.waypoints.truncate(1)),
        ("one line", |r| r.waypoints[1].name = "a\u{1}b".to_owned()),
        ("one line", |r| r.name = "a\nb".to_owned()),
    ];
    for (expected, change) in broken {
        let mut route = route();
        change(&mut route);
        for error in [rtz(&route).unwrap_err(), gpx(&[&route], &[]).unwrap_err()] {
            assert!(error.to_string().contains(expected), "{expected}: {error}");
        }
    }
    let mut wide = route();
    wide.waypoints[1] =
        Waypoint { lon_deg: 40.0, lat_deg: 0.0, turn_radius_m: Some(20_000.0), ..wide.waypoints[1].clone() };
    assert!(rtz(&wide).unwrap_err().to_string().contains("10 NM"));
}

#[test]
fn radii_are_lowered_to_fit() {
    let mut route = route();
    for waypoint in &mut route.waypoints {
        waypoint.turn_radius_m = Some(1e6);
    }
    assert!(rtz(&route).is_err());
    route.fit_radii();
    assert!((route.waypoints[1].turn_radius_m.unwrap() - 0.49 * route.leg_m(0).unwrap()).abs() < 1e-9);
    assert!(rtz(&route).is_ok());
    assert_eq!(route.leg_m(2), None);
}

#[test]
fn geometries_that_break_the_rules_are_refused() {
    let one = |geometry: Geometry| geojson(&[Feature { geometry, properties: serde_json::Map::new() }]);
    assert!(one(Geometry::Point([181.0, 0.0])).is_err());
    assert!(one(Geometry::Point([f64::NAN, 0.0])).is_err());
    assert!(one(Geometry::Line(vec![[0.0, 0.0]])).is_err());
}
