//! Routes and tracks in other formats, read back by foreign readers.

use geojson::{FeatureCollection, GeometryValue};

use crate::geometry::local_m;
use crate::planned::*;
use crate::support::*;
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

/// The waypoints of the passage in the plan.
fn waypoints(planned: &Planned) -> Vec<[f64; 2]> {
    let passage = &planned.plan["voyage"]["passage"];
    let place = |own: &serde_json::Value| [number(own, "longitude_deg"), number(own, "latitude_deg")];
    let legs = passage["legs"].as_array().unwrap().iter();
    std::iter::once(place(passage)).chain(legs.map(place)).collect()
}

fn number(own: &serde_json::Value, key: &str) -> f64 {
    own[key].as_f64().unwrap()
}

#[test]
fn law_the_passage_goes_from_node_to_node_and_turns_between_them() {
    for planned in all() {
        let places = waypoints(planned);
        let passage = planned.plan["voyage"]["passage"]["legs"].as_array().unwrap();
        let nodes: Vec<[f64; 2]> = planned
            .legs()
            .iter()
            .map(|leg| [number(leg, "longitude_deg"), number(leg, "latitude_deg")])
            .chain([*planned.track.place.last().unwrap()])
            .collect();
        let is_node = |place: [f64; 2]| nodes.iter().any(|node| metres(*node, place) < 30.0);
        assert!(is_node(places[0]));
        for (leg, place) in passage.iter().zip(&places[1..]) {
            // Courses change at nodes, where the ship turns, and along maneuvers.
            assert!(
                is_node(*place) || leg["turn_radius_m"].is_number() || leg["informative"] == true,
                "{leg}"
            );
        }
        // Every maneuver that moves is in the passage, in the order of the plan.
        let told: Vec<&str> = passage
            .iter()
            .flat_map(|leg| leg["then"].as_array().unwrap().iter().rev().chain([&leg["what"]]))
            .map(|what| what.as_str().unwrap())
            .collect();
        for leg in planned.legs().iter().filter(|leg| leg["informative"] == true) {
            let name = leg["name"].as_str().unwrap();
            let before = planned.plan["voyage"]["passage"]["before"].to_string();
            assert!(told.iter().any(|what| what.starts_with(name)) || before.contains(name), "{name}");
        }
        let end = number(&planned.plan["voyage"], "duration_s");
        let last = passage.last().unwrap();
        // What is done at rest takes its time, to the end of the trial.
        assert!((number(last, "leave_s") - end).abs() < 1e-9, "{last}");
        assert!(passage.windows(2).all(|pair| number(&pair[0], "leave_s") <= number(&pair[1], "end_s")));
        for leg in passage {
            let stays = number(leg, "leave_s") > number(leg, "end_s");
            assert_eq!(stays, !leg["then"].as_array().unwrap().is_empty(), "{leg}");
        }
    }
}

#[test]
fn law_the_track_keeps_within_the_cross_track_distances() {
    for planned in all() {
        let places = waypoints(planned);
        let passage = planned.plan["voyage"]["passage"]["legs"].as_array().unwrap();
        for place in &planned.track.place {
            // Within the corridor of some leg: abeam of it, or off one of its ends.
            let within = places.windows(2).zip(passage).any(|(ends, leg)| {
                let ([x, y], [to_x, to_y]) = (local_m(ends[0], *place), local_m(ends[0], ends[1]));
                let length = to_x.hypot(to_y);
                let along = (x * to_x + y * to_y) / length;
                // To starboard: east of a course to the north.
                let across = (x * to_y - y * to_x) / length;
                let limit = number(leg, if across > 0.0 { "xtd_starboard_m" } else { "xtd_port_m" });
                across.abs() <= limit + 0.5 && along > -600.0 && along < length + 600.0
            });
            assert!(within, "{place:?}");
        }
    }
}

#[test]
fn law_corridors_hold_the_hull_and_no_land() {
    for (planned, land) in all().into_iter().zip([HELSINKI_LAND, HELSINKI_LAND, ""]) {
        let land = match land {
            "" => crate::geometry::polygons_of(ISLAND),
            file => crate::geometry::polygons(&repository().join(file)),
        };
        let places = waypoints(planned);
        let passage = planned.plan["voyage"]["passage"]["legs"].as_array().unwrap();
        let mut wide = 0;
        for (ends, leg) in places.windows(2).zip(passage) {
            let [port, right] = ["xtd_port_m", "xtd_starboard_m"].map(|key| number(leg, key));
            // Half the beam of 8 m at least; a hull's length beside a maneuver's waypoints at most, or what vessels need.
            assert!(port >= 4.0 && right >= 4.0, "{leg}");
            wide += usize::from(port > 30.0 || right > 30.0);
            let steps = (metres(ends[0], ends[1]) / 10.0).ceil();
            for k in 0..=steps as usize {
                let share = k as f64 / steps;
                let at = [0, 1].map(|axis| ends[0][axis] + share * (ends[1][axis] - ends[0][axis]));
                for across in (0..=20).map(|j| -port + (port + right) * f64::from(j) / 20.0) {
                    let course = number(leg, "course_deg").to_radians();
                    let place = crate::geometry::moved(at, course, [0.0, across]);
                    assert!(!land.iter().any(|own| own.holds(place)), "{across} m beside {at:?}: {leg}");
                }
            }
        }
        assert!(wide > 0);
    }
}

#[test]
fn law_the_nearest_danger_bears_where_it_is() {
    let [planned, _] = helsinki_planned();
    let land = crate::geometry::polygons(&repository().join(HELSINKI_LAND));
    let passage = planned.plan["voyage"]["passage"]["legs"].as_array().unwrap();
    let mut found = 0;
    for leg in passage.iter().filter(|leg| leg["nearest"].is_object()) {
        let [away, bearing] = ["distance_m", "bearing_deg"].map(|key| number(&leg["nearest"], key));
        assert!((0.0..360.0).contains(&bearing), "{leg}");
        // From some place of the track there is land that far away in that direction.
        let beyond = |forward: f64| {
            let at = |place: &[f64; 2]| crate::geometry::moved(*place, bearing.to_radians(), [forward, 0.0]);
            planned.track.place.iter().any(|place| land.iter().any(|own| own.holds(at(place))))
        };
        assert!(beyond(away + 3.0), "{leg}");
        found += 1;
    }
    assert!(found > 3, "{found}");
}

#[test]
fn routes_have_the_name_of_the_study_and_the_speed_of_each_leg() {
    for (planned, name) in helsinki_planned().into_iter().zip(["helsinki", "helsinki plan-4-headings"]) {
        // That of RTZ is its file's, as ECDIS expect.
        let root = read(planned.text("route.rtz"));
        assert_eq!(root.one("routeInfo").get("routeName"), Some("route"));
        let gpx = read(planned.text("route.gpx"));
        let route = gpx.one("rte");
        assert_eq!(route.one("name").text, name);
        let passage = planned.plan["voyage"]["passage"]["legs"].as_array().unwrap();
        for (leg, point) in passage.iter().zip(&route.all("rtept")[1..]) {
            let knots = format!("{:.1} kn on the leg to here", number(leg, "speed_m_s") * 3600.0 / 1852.0);
            assert_eq!(point.one("cmt").text, knots);
        }
    }
}

#[test]
fn law_abort_tracks_are_routes_of_their_own_from_the_end_of_their_leg() {
    for planned in all() {
        let legs = planned.legs();
        assert!(
            legs.iter().all(|leg| leg["abort"].is_object() && leg["drift"]["drifted"].as_u64() > Some(0))
        );
        let gpx = read(planned.text("aborts.gpx"));
        let lines: FeatureCollection = planned.text("aborts.geojson").parse().unwrap();
        let ends = legs[1..].iter().map(|leg| [number(leg, "longitude_deg"), number(leg, "latitude_deg")]);
        let ends: Vec<[f64; 2]> = ends.chain([*planned.track.place.last().unwrap()]).collect();
        let sailed = |leg: &serde_json::Value| !leg["abort"]["moves"].as_array().unwrap().is_empty();
        let sailed: Vec<usize> = (0..legs.len()).filter(|step| sailed(&legs[*step])).collect();
        assert_eq!((gpx.all("rte").len(), lines.features.len()), (sailed.len(), sailed.len()));
        for (step, route) in sailed.iter().zip(gpx.all("rte")) {
            assert_eq!(route.one("name").text, format!("abort from leg {}", step + 1));
            let root = read(planned.text(&format!("abort-{}.rtz", step + 1)));
            let name = format!("abort-{}", step + 1);
            assert_eq!(root.one("routeInfo").get("routeName"), Some(name.as_str()));
            let points: Vec<[f64; 2]> = root
                .one("waypoints")
                .all("waypoint")
                .iter()
                .map(|point| place(point.one("position")))
                .collect();
            let (abort, last) = (&legs[*step]["abort"], points[points.len() - 1]);
            let to = [number(abort, "longitude_deg"), number(abort, "latitude_deg")];
            // To the tolerance of legs.
            assert!(metres(points[0], ends[*step]) < 13.0 && metres(last, to) < 13.0, "{step} {points:?}");
            assert!(route.all("rtept").iter().zip(&points).all(|(point, own)| near(place(point), *own)));
            let apart = metres(ends[*step], to);
            assert!((number(abort, "distance_m") - apart).abs() < 0.01 * apart + 13.0, "{abort}");
        }
    }
}

#[test]
fn abort_tracks_that_are_required_and_have_no_room_are_refused() {
    let wanted = "headings = 4\nabort = \"required\"\nabort_room_m = 5000.0";
    refused(&small_with(&[("headings = 4", wanted)]), 4, PLAN, &["plan.toml", "`abort`", "without room"]);
}

#[test]
fn a_departure_gives_routes_their_times_of_day() {
    let planned = plan_small(&[("headings = 4", "headings = 4\ndeparture = \"2026-06-01T11:00:00+03:00\"")]);
    assert_eq!(planned.plan["voyage"]["passage"]["departure"], "2026-06-01T08:00:00Z");
    let root = read(planned.text("route.rtz"));
    let times = root.one("schedules").one("schedule").one("calculated").all("sheduleElement");
    assert_eq!(times[0].get("etd"), Some("2026-06-01T08:00:00Z"));
    assert!(times[1..].windows(2).all(|pair| pair[0].get("eta").unwrap() <= pair[1].get("eta").unwrap()));
    let gpx = read(planned.text("route.gpx"));
    let track = gpx.one("trk").one("trkseg").all("trkpt");
    assert_eq!(track[0].one("time").text, "2026-06-01T08:00:00Z");
}

#[test]
fn a_departure_that_is_no_time_is_refused() {
    for wrong in ["2026-06-01T08:00:00", "tomorrow", "2026-06-31T08:00:00Z"] {
        let folder = small_with(&[("headings = 4", &format!("headings = 4\ndeparture = \"{wrong}\""))]);
        run(&folder, PLAN).refuses(3, &["plan.toml", "departure", wrong, "2026-06-01T08:00:00Z"]);
        assert!(!folder.path().join("plan.json").exists());
    }
}

#[test]
fn the_rtz_route_keeps_the_rules_of_version_1_0_and_passes_the_waypoints() {
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
