//! Plans among traffic lanes, with water under the keel, and orders for the bridge.

use serde_json::json;

use crate::geometry::{Polygon, local_m, polygons_of};
use crate::planned::*;
use crate::support::*;

type Box = [f64; 4];

const AREA: Box = [24.96, 59.98, 25.04, 60.02];
const ISLE: Box = [24.998, 59.999, 25.002, 60.001];
const LANE: Box = [24.99, 60.002, 25.01, 60.008];

/// Objects of an electronic chart as GDAL writes them: code, attributes, edges.
fn objects(all: &[(u32, serde_json::Value, Box)]) -> String {
    let feature = |(code, attributes, [west, south, east, north]): &(u32, serde_json::Value, Box)| {
        let mut properties = attributes.clone();
        properties["OBJL"] = json!(code);
        let ring = [[west, south], [east, south], [east, north], [west, north], [west, south]];
        let geometry = json!({"type": "Polygon", "coordinates": [ring]});
        json!({"type": "Feature", "properties": properties, "geometry": geometry})
    };
    json!({"type": "FeatureCollection", "features": all.iter().map(feature).collect::<Vec<_>>()}).to_string()
}

const DEPARE: u32 = 42;
const FAIRWY: u32 = 51;
const LNDARE: u32 = 71;
const TSSLPT: u32 = 148;
const PRCARE: u32 = 96;
const ACHARE: u32 = 4;
const UNSARE: u32 = 154;

/// The small study on such a chart of water of 20 m with an isle, and what else there is.
fn charted(more: &[(u32, serde_json::Value, Box)], changes: &[(&str, &str)]) -> tempfile::TempDir {
    let folder = small_with(&[
        (
            "file = \"land.geojson\"\nkind = \"land\"",
            "file = \"bay.geojson\"\nkind = \"objects\"\nrules = {}",
        ),
        ("margin_m = 20.0", "margin_m = 20.0\ntransit_depth_m = 5.0\ntrial_depth_m = 8.0"),
    ]);
    changes.iter().for_each(|(from, to)| edit(&folder, "plan.toml", from, to));
    let usual = [(DEPARE, json!({"DRVAL1": 20.0}), AREA), (LNDARE, json!({}), ISLE)];
    put(&folder, "bay.geojson", &objects(&[&usual[..], more].concat()));
    folder
}

fn lane(orient: impl serde::Serialize) -> (u32, serde_json::Value, Box) {
    (TSSLPT, json!({"ORIENT": orient, "OBJNAM": "Off Holm"}), LANE)
}

/// A strip from south to north between the start and the room for maneuvers.
const STRIP: Box = [24.9875, 59.98, 24.9925, 60.02];

/// The courses of a track in `polygon` over ground, each over 20 m, from the direction \[deg\].
fn off(places: &[[f64; 2]], polygon: &Polygon, towards: f64) -> Vec<f64> {
    let (mut all, mut last) = (Vec::new(), places[0]);
    for place in places {
        let [east, north] = local_m(last, *place);
        if east.hypot(north) < 20.0 {
            continue;
        }
        if polygon.holds(last) && polygon.holds(*place) {
            let turned = (east.atan2(north).to_degrees() - towards).rem_euclid(360.0);
            all.push(turned.min(360.0 - turned));
        }
        last = *place;
    }
    all
}

#[test]
fn law_plans_and_abort_tracks_go_along_a_lane_or_across_it_and_never_against_it() {
    let lane = |towards: f64| (TSSLPT, json!({"ORIENT": towards}), STRIP);
    let to_the_east =
        "kind = \"places\"\nplaces = [{ longitude_deg = 25.012, latitude_deg = 60.004, heading_deg = 90.0 }]";
    for towards in [0.0, 90.0, 190.0] {
        let folder = charted(&[lane(towards)], &[("kind = \"home\"", to_the_east)]);
        run(&folder, PLAN).succeeds();
        let planned = Planned::of(&folder);
        let strip = polygons_of(&objects(&[lane(towards)])).remove(0);
        let courses = off(&planned.track.place, &strip, towards);
        // Straight over it.
        assert!(courses.len() > 8, "{courses:?}");
        let aborts: serde_json::Value = serde_json::from_str(planned.text("aborts.geojson")).unwrap();
        let aborts = aborts["features"].as_array().unwrap().iter().filter_map(|feature| {
            let geometry = &feature["geometry"];
            let line = || serde_json::from_value::<Vec<[f64; 2]>>(geometry["coordinates"].clone()).unwrap();
            (geometry["type"] == "LineString").then(line)
        });
        let aborts: Vec<Vec<[f64; 2]>> = aborts.collect();
        assert!(!aborts.is_empty());
        for off in aborts.iter().flat_map(|line| off(line, &strip, towards)).chain(courses) {
            assert!(off < 50.0 || (off - 90.0).abs() < 25.0, "{off} from {towards}");
        }
        // She waits in no lane.
        for leg in planned.voyage()["legs"].as_array().unwrap() {
            let abort = &leg["abort"];
            if abort["moves"].as_array().is_some_and(|moves| !moves.is_empty()) {
                let place = ["longitude_deg", "latitude_deg"].map(|key| abort[key].as_f64().unwrap());
                assert!(!strip.holds(place), "{abort}");
            }
        }
    }
    let folder = charted(&[lane(270.0)], &[("kind = \"home\"", to_the_east)]);
    refused(&folder, 4, PLAN, &["against the traffic", "`traffic.crossing_deg`"]);
}

#[test]
fn she_waits_at_anchorages_that_are_deep_enough_and_never_where_nothing_is_surveyed() {
    let roads: Box = [24.982, 59.9925, 24.993, 59.9985];
    let places = |more: &[(u32, serde_json::Value, Box)]| {
        let folder = charted(more, &[]);
        run(&folder, PLAN).succeeds();
        let legs = Planned::of(&folder).voyage()["legs"].clone();
        let place = |leg: &serde_json::Value| {
            let abort = leg.get("abort")?;
            let place = ["longitude_deg", "latitude_deg"].map(|key| abort[key].as_f64().unwrap());
            Some((abort["kind"] == "anchorage", place))
        };
        legs.as_array().unwrap().iter().filter_map(place).collect::<Vec<_>>()
    };
    let anchorage = (ACHARE, json!({"OBJNAM": "Roads"}), roads);
    let within = |[x, y]: [f64; 2]| roads[0] <= x && x <= roads[2] && roads[1] <= y && y <= roads[3];
    let deep = places(std::slice::from_ref(&anchorage));
    assert!(deep.iter().any(|(is_anchorage, _)| *is_anchorage), "{deep:?}");
    assert!(deep.iter().all(|(is_anchorage, place)| *is_anchorage == within(*place)), "{deep:?}");
    for closed in [(DEPARE, json!({"DRVAL1": 2.0}), roads), (UNSARE, json!({}), roads)] {
        let shallow = places(&[anchorage.clone(), closed]);
        let outside = |(is_anchorage, place): &(bool, [f64; 2])| !is_anchorage && !within(*place);
        assert!(!shallow.is_empty() && shallow.iter().all(outside), "{shallow:?}");
    }
}

#[test]
fn directions_that_are_none_are_refused_or_kept_out_of() {
    let folder = charted(&[lane(400.0)], &[]);
    refused(
        &folder,
        3,
        PLAN,
        &["bay.geojson", "TSSLPT feature 2, `ORIENT`", "400", "rules = { TSSLPT = \"avoid\" }"],
    );
    edit(&folder, "plan.toml", "rules = {}", "rules = { TSSLPT = \"avoid\" }");
    run(&folder, PLAN).succeeds();
    // Without a direction she keeps out, and that is told.
    let folder = charted(&[lane("")], &[]);
    run(&folder, PLAN).succeeds();
    let classes = json(&folder, "plan.json")["data"]["charts"][0]["classes"]["TSSLPT"].clone();
    assert_eq!((&classes["avoided"], &classes["objects"]), (&json!(1), &json!(1)));
    for wrong in ["-1.0", "46.0", "nan"] {
        let folder = charted(&[], &[("[start]", &format!("[traffic]\ncrossing_deg = {wrong}\n[start]"))]);
        refused(&folder, 3, PLAN, &["plan.toml", "crossing_deg"]);
    }
}

#[test]
fn a_refusal_counts_the_room_that_each_class_takes_and_leaving_it_out_proves_it() {
    let zones =
        [(FAIRWY, json!({}), [24.96, 59.98, 25.0, 60.02]), (PRCARE, json!({}), [25.0, 59.98, 25.04, 60.02])];
    let folder = charted(&zones, &[]);
    let told = run(&folder, PLAN)
        .refuses(4, &["`zig-zag-steep` has room for 0 moves, without FAIRWY ", "without PRCARE "]);
    let without = told.stderr.split("without FAIRWY ").nth(1).unwrap();
    let moves: u32 = without.split(|c: char| !c.is_ascii_digit()).next().unwrap().parse().unwrap();
    assert!(moves > 0);
    edit(&folder, "plan.toml", "rules = {}", "rules = { FAIRWY = \"ignore\" }");
    run(&folder, PLAN).succeeds();
    let primitives = Planned::of(&folder).voyage()["primitives"].clone();
    let fits = primitives.as_array().unwrap().iter().filter(|p| p["maneuver"] == "zig-zag-steep");
    assert_eq!(fits.map(|p| p["fits"].as_u64().unwrap()).sum::<u64>(), u64::from(moves));
}

#[test]
fn water_under_the_keel_is_depth_less_draught_and_squat_and_too_little_is_refused() {
    let hull = "beam_m = 8.0\ndraught_m = 3.0\nblock_coefficient = 0.8";
    let folder = charted(&[], &[("beam_m = 8.0", hull)]);
    run(&folder, PLAN).succeeds();
    let passage = Planned::of(&folder).voyage()["passage"].clone();
    for leg in passage["legs"].as_array().unwrap() {
        let number = |key: &str| leg[key].as_f64().unwrap();
        // Barrass in open water, by hand.
        let knots = number("speed_m_s") / 0.514_444;
        assert!((number("squat_m") - 0.008 * knots * knots).abs() < 1e-6);
        assert!((number("under_keel_m") - (20.0 - 3.0 - number("squat_m"))).abs() < 1e-9);
        for side in ["xtd_port_m", "xtd_starboard_m"] {
            assert!(number(side) >= 10.0);
        }
    }
    edit(&folder, "plan.toml", "margin_m = 20.0", "margin_m = 20.0\nunder_keel_m = 16.95");
    let what = ["m under the keel on leg", "charted 20.0 m, squat", "`safety.under_keel_m`, 16.95 m"];
    refused(&folder, 4, PLAN, &what);
    edit(&folder, "plan.toml", "under_keel_m = 16.95", "under_keel_m = 16.9");
    run(&folder, PLAN).succeeds();
    edit(&folder, "plan.toml", "draught_m = 3.0\n", "");
    refused(&folder, 3, PLAN, &["safety.under_keel_m", "without `hull.draught_m`"]);
}

#[test]
fn the_bridge_is_told_the_side_the_heading_and_where_the_helm_goes_over() {
    let planned = helsinki_planned()[0];
    let mut told = 0;
    for leg in planned.voyage()["legs"].as_array().unwrap() {
        let Some(order) = leg["order"].as_str() else {
            assert!(leg["informative"] == false && leg.get("wheel_over").is_none());
            continue;
        };
        if leg["name"] == "sway-zig-zag" {
            assert!(leg.get("wheel_over").is_none(), "a controller gives its orders all the time");
            continue;
        }
        told += 1;
        assert!(!order.contains("mirrored") && order.ends_with('°'), "{order}");
        let at = leg["wheel_over"].as_array().unwrap();
        assert_eq!(at[0]["start_s"], leg["maneuver_start_s"]);
        let heading = at[0]["heading_deg"].as_f64().unwrap().round() % 360.0;
        assert!(order.ends_with(&format!(" {heading:03.0}°")), "{order}, {heading}");
        let starts: Vec<f64> = at.iter().map(|at| at["start_s"].as_f64().unwrap()).collect();
        assert!(starts.is_sorted_by(|a, b| a < b));
        let name = leg["name"].as_str().unwrap();
        let (words, orders) = match name {
            "zig-zag-20" => ("zig-zag 20, first to ", 3..12),
            "circle" => ("turning circle, first to ", 1..2),
            _ => ("crash stop, order -60 kN, from ", 1..2),
        };
        assert!(order.starts_with(words) && orders.contains(&at.len()), "{order}: {}", at.len());
        // The helm goes over to the side that is told first, and then to the other.
        let helm: Vec<f64> = at.iter().map(|at| at["inputs"]["tau3"].as_f64().unwrap()).collect();
        let sign = if order.contains("first to starboard") { 1.0 } else { -1.0 };
        assert!(name == "crash-stop" || helm[0] * sign > 0.0);
        assert!(helm.windows(2).all(|pair| pair[0] * pair[1] < 0.0 || name == "crash-stop"), "{helm:?}");
    }
    assert_eq!(told, 9);
    let routes = planned.text("route.rtz");
    assert!(!routes.contains("mirrored"));
}
