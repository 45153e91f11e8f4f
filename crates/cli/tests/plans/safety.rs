//! The check of a plan, its consequences, and dangers charted as a point or a line.

use std::fs;

use serde_json::Value;
use tempfile::TempDir;

use crate::planned::*;
use crate::support::*;
use crate::xml::read;

/// Next to the island: the start of the small plan.
const START: &str = "longitude_deg = 24.985\nlatitude_deg = 60.0";
const OWN_CHART: &str = "[[chart]]\nfile = \"land.geojson\"\nkind = \"land\"";

/// The small study with a vessel with very uncertain parameters: one that is searched ends a leg far off.
fn strained() -> TempDir {
    small_with(&[("runs = 4", "runs = 64\nparameter_error = 0.7"), ("margin_m = 20.0", "margin_m = 60.0")])
}

#[test]
fn a_plan_that_fails_its_check_is_refused_and_writes_nothing() {
    let folder = strained();
    // What the check found makes the next search find no leg.
    let pieces =
        ["plan.toml", "maneuver `zig-zag-steep`", "no leg on which all sampled vessels settle, such as N_r"];
    refused(&folder, 4, PLAN, &pieces);
    assert!(PLANNED.iter().all(|name| !folder.path().join(name).exists()));
}

#[test]
fn a_plan_that_fails_its_check_and_is_allowed_says_so_in_every_output() {
    let folder = strained();
    run(&folder, &format!("{PLAN} --allow=unsafe")).succeeds();
    let planned = Planned::of(&folder);
    let check = &planned.voyage()["check"];
    assert_eq!(check["safe"], false, "{check}");
    let fault = check["faults"][0].as_str().unwrap();
    assert!(fault.contains("vessels searched one (N_r") && fault.contains("on step"), "{fault}");
    assert!(planned.plan["statement"].as_str().unwrap().contains(fault));
    let route = read(planned.text("route.rtz"));
    assert_eq!(route.one("routeInfo").get("routeName"), Some("route (unsafe)"));
    let legs = route.one("waypoints").all("waypoint").into_iter().flat_map(|point| point.all("leg"));
    assert!(legs.map(|leg| leg.get("legInfo").unwrap()).all(|note| note.starts_with("unsafe plan: ")));
    let gpx = planned.text("route.gpx");
    assert!(gpx.contains("small trial (unsafe)") && gpx.contains("planned track (unsafe)"));
    let track: Value = serde_json::from_str(planned.text("track.geojson")).unwrap();
    assert!(track["features"].as_array().unwrap().iter().all(|f| f["properties"]["safe"] == false));
    assert!(planned.text("route.plan").contains("small trial (unsafe)"));
    assert!(planned.text("map.svg").contains("Unsafe: the plan fails its own check"));
    assert!(planned.text("map.json").contains("\"safe\": false"));
    let folder = planned.study.with(&["plan.json", "map.svg", "dictionary.parquet"]);
    fs::create_dir(folder.path().join("out")).unwrap();
    for name in ["plan.json", "track.parquet", "track.geojson", "route.rtz", "route.gpx", "map.svg"] {
        fs::write(folder.path().join("out").join(name), planned.study.bytes(name)).unwrap();
    }
    run(&folder, "report --study . --results out --out out/report.html").succeeds();
    assert!(drawn(&folder, "out/report.html").as_array().unwrap().is_empty(), "a drawing has no layers");
    fs::write(folder.path().join("out/map.json"), planned.study.bytes("map.json")).unwrap();
    run(&folder, "report --study . --results out --out out/report.html").succeeds();
    let panels = drawn(&folder, "out/report.html");
    let page = String::from_utf8(bytes(&folder, "out/report.html")).unwrap();
    let steps = planned.plan["steps"].as_array().unwrap().len();
    assert_eq!(page.matches(" data-step=").count(), steps);
    let linked =
        panels[0]["data"]["tracks"].as_array().unwrap().iter().map(|track| track[4].as_u64().unwrap());
    assert_eq!(linked.max(), Some(steps as u64 - 1));
    for said in ["<b>Unsafe.</b>", "<b>Not for navigation.</b>", fault] {
        assert!(page.contains(said), "{said}");
    }
    let small = small_planned();
    assert_eq!(small.voyage()["check"]["safe"], true);
    PLANNED.iter().filter(|name| !name.ends_with("parquet")).for_each(|name| {
        let text = String::from_utf8_lossy(small.study.bytes(name));
        assert!(!text.to_lowercase().contains("unsafe"), "{name}");
    });
}

#[test]
fn law_the_interval_of_the_share_aground_is_wilsons() {
    let [eight, four] = helsinki_planned();
    for planned in [eight, four, small_planned()] {
        let check = &planned.voyage()["check"];
        let number = |key: &str| check[key].as_f64().unwrap();
        let (n, z2) = (number("runs"), 1.959_963_984_540_054_f64.powi(2));
        let share = number("aground") / n;
        let interval: [f64; 2] = serde_json::from_value(check["aground_interval"].clone()).unwrap();
        // Both ends solve (p − share)² = z² p (1 − p) / n.
        for p in interval {
            assert!(((p - share).powi(2) - z2 * p * (1.0 - p) / n).abs() < 1e-9, "{check}");
        }
        assert!(interval[0] <= share && share <= interval[1] && check["seed"] == 1);
        // If going aground were as probable as the bound, no case in so many runs would have this probability: half
        // of 5 % in the first round, half of that in the next.
        let doubt = 0.05 * 0.5_f64.powf(number("rounds"));
        let bound = number("aground_bound");
        assert!(((1.0 - bound).powf(n) - doubt).abs() < 1e-9, "{check}");
    }
}

#[test]
fn the_check_sails_no_true_parameters_but_draws_them_within_the_stated_error() {
    let quantiles = |error: &str| {
        let exact = format!("unknown_current_m_s = 0.0\nparameter_error = {error}\nruns = 8");
        let planned = plan_small(&[("unknown_current_m_s = 0.05\nruns = 4", &exact)]);
        let all: [f64; 3] =
            serde_json::from_value(planned.voyage()["check"]["sailed_quantiles_s"].clone()).unwrap();
        (planned.number("/voyage/check/sailed_s"), all)
    };
    // The vessel's true parameters are not the nominal ones, and would give another track.
    let (sailed, runs) = quantiles("0.0");
    assert_eq!(runs, [sailed; 3]);
    let (_, runs) = quantiles("0.5");
    assert!(runs[0] < runs[1] && runs[1] < runs[2], "{runs:?}");
}

#[test]
fn law_the_worst_vessels_are_within_the_stated_errors_and_keep_what_the_plan_states() {
    for planned in helsinki_planned() {
        let (check, worst) = (&planned.voyage()["check"], &planned.voyage()["check"]["worst"]);
        let number = |key: &str| worst[key].as_f64().unwrap();
        assert!(number("searched") > 100.0, "{worst}");
        assert!(["aground", "below_margin", "ends_astray"].iter().all(|key| worst[*key] == 0), "{worst}");
        assert!(number("clearance_m") >= check["margin_m"].as_f64().unwrap(), "{worst}");
        assert!(
            number("tolerance_used") <= 1.0
                && number("tolerance_used") > planned.number("/voyage/check/tolerance_used")
        );
        for who in ["nearest", "farthest"] {
            let off = worst[who]["parameters_percent"].as_object().unwrap();
            assert!(
                off.len() == 10 && off.values().all(|own| own.as_f64().unwrap().abs() <= 35.0),
                "{worst}"
            );
            assert!(worst[who]["current_m_s"].as_f64().unwrap() <= 0.15 + 1e-12, "{worst}");
        }
        // What ends a leg farthest off is a corner of the errors, which even draws do not meet.
        let off = worst["farthest"]["parameters_percent"].as_object().unwrap();
        assert!(off.values().all(|own| own.as_f64().unwrap().abs() == 35.0), "{worst}");
    }
    // Every run has a vessel of its own, whatever an older file says.
    let older = plan_small(&[("runs = 4", "runs = 4\nvessels = 2")]);
    assert_eq!(older.voyage()["check"], small_planned().voyage()["check"]);
    // Without errors there is nothing to search.
    let exact = plan_small(&[("unknown_current_m_s = 0.05\n", "")]);
    assert_eq!(exact.voyage()["check"].get("worst"), None);
}

#[test]
fn a_box_with_vessels_that_cannot_be_steered_is_refused_by_their_parameters() {
    let folder = small_with(&[("runs = 4", "runs = 4\nparameter_error = 0.99")]);
    let pieces = ["plan.toml", "`safety.parameter_error`", "X_tau -99", "cannot be steered", "lower it"];
    refused(&folder, 3, PLAN, &pieces);
    assert!(PLANNED.iter().all(|name| !folder.path().join(name).exists()));
    let folder = small_with(&[("runs = 4", "runs = 4\nparameter_error = 0.9")]);
    let pieces = [
        "maneuver `zig-zag-steep`",
        "no leg on which all sampled vessels settle, such as N_r",
        "know the parameters better",
    ];
    refused(&folder, 4, PLAN, &pieces);
}

#[test]
fn law_noise_of_sensors_reaches_the_check_and_only_that_of_its_own_seed() {
    let noisy = "[sensors]\nposition_m = 2.0\nheading_deg = 1.0\nspeed_m_s = 0.05\n\n[handling]";
    let [exact, none, some, again] =
        ["[handling]", "[sensors]\nposition_m = 0.0\n\n[handling]", noisy, noisy]
            .map(|sensors| plan_small(&[("[handling]", sensors)]).voyage()["check"].clone());
    assert_eq!(exact, none);
    assert_eq!(some, again);
    assert_ne!(exact["worst"], some["worst"]);
    let astray = |check: &Value| check["ends_astray"].as_f64().unwrap() / check["ends"].as_f64().unwrap();
    assert!(astray(&exact) == 0.0 && astray(&some) <= 0.01 && some["safe"] == true, "{some}");
    let coarse = small_with(&[("[handling]", "[sensors]\nposition_m = 20.0\n\n[handling]")]);
    refused(
        &coarse,
        3,
        PLAN,
        &["`approach.tolerance_cells`", "2 standard deviations of `sensors.position_m`"],
    );
}

#[test]
fn the_areas_edge_is_no_obstacle_and_nobody_crosses_it() {
    let folder = small_with(&[
        (START, "longitude_deg = 24.9815\nlatitude_deg = 59.994"),
        ("runs = 4", "runs = 32\nparameter_error = 0.5"),
    ]);
    // The island is beyond the measured distances.
    let far = [("24.998", "25.0165"), ("25.002", "25.0185"), ("59.999", "60.0065"), ("60.001", "60.0085")];
    let land = far.iter().fold(ISLAND.to_owned(), |land, (from, to)| land.replace(from, to));
    put(&folder, "land.geojson", &land);
    let ran = run(&folder, PLAN).succeeds();
    assert!(ran.stdout.contains("more than"), "{ran}");
    let planned = Planned::of(&folder);
    let check = &planned.voyage()["check"];
    assert_eq!((&check["safe"], &check["clearance_m"]), (&true.into(), &check["sight_m"]), "{check}");
    assert!(check["left_area"] == 0 && check["aground"] == 0, "{check}");
    let edge = small_with(&[
        (START, "longitude_deg = 24.9801\nlatitude_deg = 60.0"),
        ("heading_deg = 0.0", "heading_deg = 90.0"),
        ("length_m = 30.0", "length_m = 200.0"),
    ]);
    refused(&edge, 4, PLAN, &["`start`", "the hull reaches out of `area`", "the nearest clear node is"]);
}

#[test]
fn law_as_many_runs_leave_what_is_read_of_the_chart_as_drift_off_it() {
    let (runs, strongest_m_s) = (2000, 0.6);
    let folder = small_with(&[
        ("kind = \"land\"", "kind = \"land\"\nopen_sea = true"),
        ("unknown_current_m_s = 0.05\nruns = 4", "unknown_current_m_s = 0.6\nruns = 2000"),
    ]);
    put(&folder, "land.geojson", &ISLAND.replace("59.", "61.").replace("60.", "61."));
    run(&folder, PLAN).succeeds();
    let planned = Planned::of(&folder);
    let check = &planned.voyage()["check"];
    assert!(check["aground"] == 0 && check["clearance_m"] == check["sight_m"], "{check}");
    // Without corrections a vessel with known parameters follows the nominal track and drifts: there is no other
    // deviation.
    let lattice = |key: &str| planned.number(&format!("/voyage/lattice/{key}"));
    let first = [lattice("longitude_deg"), lattice("latitude_deg")];
    let edges = |nodes: &str| [-500.0, lattice("cell_m") * lattice(nodes) + 500.0];
    let half_m = lattice("cell_m") / 2.0;
    let track = planned.track.place.iter().zip(&planned.track.t);
    let places: Vec<([f64; 2], f64)> =
        track.map(|(place, t)| (east_north_m(first, *place).map(|m| m + half_m), *t)).collect();
    let [[west, east], [south, north]] = ["nx", "ny"].map(edges);
    let leaves = |[v_east, v_north]: [f64; 2]| {
        places.iter().any(|([x, y], t)| {
            let (x, y) = (x + v_east * t, y + v_north * t);
            !(west..east).contains(&x) || !(south..north).contains(&y)
        })
    };
    let drawn = (0..120).flat_map(|angle| (0..50).map(move |part| (f64::from(angle), f64::from(part))));
    let left = drawn.filter(|(angle, part)| {
        let (sin, cos) = (angle * std::f64::consts::TAU / 120.0).sin_cos();
        let speed = strongest_m_s * (part + 0.5) / 50.0;
        leaves([speed * sin, speed * cos])
    });
    let expected = left.count() as f64 / 6000.0;
    let share = check["aground_open_loop"].as_f64().unwrap() / f64::from(runs);
    let spread = (expected * (1.0 - expected) / f64::from(runs)).sqrt();
    assert!(expected > 0.03 && expected < 0.9, "{expected}");
    assert!((share - expected).abs() < 4.0 * spread, "{share} {expected}");
}

/// East and north of a place a few kilometres from another, on a sphere \[m\].
fn east_north_m(from: [f64; 2], [lon, lat]: [f64; 2]) -> [f64; 2] {
    let north = (lat - from[1]).to_radians();
    let east = (lon - from[0]).to_radians() * ((lat + from[1]) / 2.0).to_radians().cos();
    [east, north].map(|angle| 6_371_000.0 * angle)
}

/// The small study with a chart `[[chart]]` of dangers in addition to the land, at a place near its start.
fn dangers(keys: &str, depth: &str) -> TempDir {
    let chart = format!("{OWN_CHART}\n[[chart]]\nfile = \"wrecks.geojson\"\n{keys}");
    let folder = small_with(&[
        (OWN_CHART, &chart),
        ("margin_m = 20.0", "margin_m = 20.0\ntransit_depth_m = 5.0\ntrial_depth_m = 8.0"),
    ]);
    let wreck = format!(
        r#"{{"type": "Feature", "properties": {{"VALSOU": {depth}}}, "geometry": {{"type": "Point", "coordinates": [24.985, 60.0003]}}}}"#
    );
    let line = wreck.replace(
        "\"Point\", \"coordinates\": [24.985, 60.0003]",
        "\"MultiLineString\", \"coordinates\": [[[24.984, 60.0004], [24.986, 60.0004]]]",
    );
    put(
        &folder,
        "wrecks.geojson",
        &format!(r#"{{"type": "FeatureCollection", "features": [{wreck}, {line}]}}"#),
    );
    folder
}

#[test]
fn charted_points_and_lines_are_obstacles_as_deep_and_wide_as_they_are_dangerous() {
    // 33 m north of the start: within 50 m, the default, but not within 5 m and a margin of 20 m of a hull 30 m long.
    let near = ["`start`", "m from an obstacle", "the nearest clear node is"];
    for kind in ["land", "no-go", "danger", "depth\"\nleast = \"VALSOU"] {
        refused(&dangers(&format!("kind = \"{kind}\""), "3.5"), 4, &format!("{PLAN} --allow=unsafe"), &near);
    }
    refused(&dangers("kind = \"danger\"", "null"), 4, PLAN, &near);
    run(&dangers("kind = \"danger\"", "8.5"), PLAN).succeeds();
    // Deep enough to pass over, too shoal for maneuvers: they are planned elsewhere.
    let folder = dangers("kind = \"danger\"\nradius_m = 700.0", "6.5");
    run(&folder, PLAN).succeeds();
    let planned = Planned::of(&folder);
    let on_it = planned.track.stretches().into_iter().flatten().filter(|row| {
        let [x, y] = crate::geometry::local_m([24.985, 60.0003], planned.track.place[*row]);
        x.hypot(y) < 700.0
    });
    assert_eq!(on_it.count(), 0);
    assert!(planned.text("map.svg").contains("no-go"));
}

#[test]
fn dangers_that_make_no_sense_are_refused() {
    let file = ["wrecks.geojson", "feature 0", "`VALSOU`", "at most 12000 m"];
    for fill in ["-32768", "9.97e36", "\"NaN\""] {
        refused(&dangers("kind = \"danger\"", fill), 3, PLAN, &file);
    }
    for radius in ["0.0", "-5.0", "1e9"] {
        let pieces = ["plan.toml", "`radius_m` of chart `wrecks.geojson`"];
        refused(&dangers(&format!("kind = \"danger\"\nradius_m = {radius}"), "3"), 3, PLAN, &pieces);
    }
    let folder = dangers("kind = \"danger\"", "3");
    edit(&folder, "wrecks.geojson", r#"{"type": "Point", "coordinates": [24.985, 60.0003]}"#, "null");
    refused(&folder, 3, PLAN, &["wrecks.geojson", "1 of 2 features without a geometry"]);
}
