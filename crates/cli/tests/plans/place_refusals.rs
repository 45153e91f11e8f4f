//! Infeasible trials: no water, no space, no way. Exit code 4, or 3 if plan.toml itself is invalid.

use crate::planned::*;
use crate::support::*;

const START: &str = "longitude_deg = 24.985\nlatitude_deg = 60.0";
const GOAL: &str = "kind = \"home\"";

fn at(longitude: f64, latitude: f64) -> String {
    format!("longitude_deg = {longitude}\nlatitude_deg = {latitude}")
}

fn to(longitude: f64, latitude: f64) -> String {
    let place = format!("longitude_deg = {longitude}, latitude_deg = {latitude}, heading_deg = 0.0");
    format!("kind = \"places\"\nplaces = [{{ {place} }}]")
}

/// A ring of land around a place, `inner` degrees of latitude free and `outer` in all.
fn ring(longitude: f64, latitude: f64, inner: f64, outer: f64) -> String {
    let square = |half: f64| {
        let (x, y) = (2.0 * half, half);
        let corner = |sx: f64, sy: f64| format!("[{}, {}]", longitude + sx * x, latitude + sy * y);
        let corners =
            [corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0), corner(-1.0, -1.0)];
        format!("[{}]", corners.join(", "))
    };
    let head = ISLAND.split_once("\"coordinates\": ").unwrap().0;
    format!("{head}\"coordinates\": [{}, {}]}}}}]}}", square(outer), square(inner))
}

#[test]
fn a_start_or_goal_on_land_is_refused_with_the_nearest_clear_node() {
    let folder = small_with(&[(START, &at(25.0, 60.0))]);
    refused(
        &folder,
        4,
        PLAN,
        &["plan.toml", "`start`", "0 m from an obstacle", "the nearest clear node is", "m away", "N 25."],
    );
    let folder = small_with(&[(GOAL, &to(25.0, 60.0))]);
    refused(&folder, 4, PLAN, &["plan.toml", "`goal`", "the nearest clear node is", "m away"]);
}

#[test]
fn a_start_within_the_margin_is_refused() {
    // 50 m north of the island's shore, the hull of 30 m across: no 40 m are left.
    let folder = small_with(&[
        (START, &at(25.0, 60.00145)),
        ("margin_m = 20.0", "margin_m = 40.0"),
        ("heading_deg = 0.0", "heading_deg = 90.0"),
    ]);
    refused(&folder, 4, PLAN, &["`start`", "at least 40 m clear", "the nearest clear node is"]);
}

#[test]
fn places_off_the_chart_are_refused() {
    for (lon, lat) in [(24.9, 60.0), (25.03, 60.0), (25.0, 60.02), (25.0, 59.98), (0.0, 0.0), (500.0, 60.0)] {
        let folder = small_with(&[(START, &at(lon, lat))]);
        refused(&folder, 3, PLAN, &["plan.toml", "`start`", "inside `area`", "widen"]);
        let folder = small_with(&[(GOAL, &to(lon, lat))]);
        refused(&folder, 3, PLAN, &["plan.toml", "`goal.places`", "inside `area`"]);
    }
}

#[test]
fn a_start_without_room_to_turn_says_where_the_nearest_room_is() {
    // A pond: space for the hull at rest, but not for a turn of 30 m and a margin, or a way ahead.
    let folder = small_with(&[(START, &at(25.0, 60.0))]);
    put(&folder, "land.geojson", &ring(25.0006, 60.0005, 0.0006, 0.004));
    let ran = run(&folder, PLAN);
    assert_eq!(ran.code, Some(4), "{ran}");
    refused(&folder, 4, PLAN, &["start", "m away"]);
}

#[test]
fn places_south_and_west_are_told_as_such() {
    // The same pond.
    let folder = small_with(&[
        ("west_deg = 24.98", "west_deg = -25.02"),
        ("east_deg = 25.02", "east_deg = -24.98"),
        ("south_deg = 59.99", "south_deg = -60.01"),
        ("north_deg = 60.01", "north_deg = -59.99"),
        (START, &at(-25.0, -60.0)),
    ]);
    put(&folder, "land.geojson", &ring(-25.0006, -60.0005, 0.0006, 0.004));
    refused(&folder, 4, PLAN, &["start", "m away", " S ", " W heading"]);
}

#[test]
fn a_goal_that_no_way_leads_to_is_told() {
    // The goal in a lagoon of 700 m.
    let folder = small_with(&[(GOAL, &to(25.003, 60.0))]);
    put(&folder, "land.geojson", &ring(25.003, 60.0, 0.0032, 0.0042));
    refused(&folder, 4, PLAN, &["none (proved)", "no moves lead from the start to the goal", "m away"]);
}

#[test]
fn a_maneuver_that_fits_nowhere_is_named() {
    // Free water of about 600 m: turns fit, the steep zig-zag does not.
    let folder = small_with(&[(START, &at(25.0, 60.0))]);
    put(&folder, "land.geojson", &ring(25.0, 60.0, 0.0022, 0.009));
    refused(
        &folder,
        4,
        PLAN,
        &["none (proved)", "`zig-zag-steep` fits nowhere", "change counts, map, start or goal"],
    );
}

#[test]
fn a_lattice_that_is_all_land_is_told() {
    let folder = small();
    let head = ISLAND.split_once("\"coordinates\": ").unwrap().0;
    let all = "[[[24.9, 59.9], [25.1, 59.9], [25.1, 60.1], [24.9, 60.1], [24.9, 59.9]]]";
    put(&folder, "land.geojson", &format!("{head}\"coordinates\": {all}}}}}]}}"));
    refused(&folder, 4, PLAN, &["`start`", "no node of the lattice is clear: 100 % by land"]);
}

#[test]
fn more_states_than_memory_allows_are_told_with_what_to_reduce() {
    let folder = small_with(&[
        ("count = 1 }, {", "count = 200 }, {"),
        ("\"sway-zig-zag\", count = 1", "\"sway-zig-zag\", count = 200"),
    ]);
    let line = format!("{PLAN} --memory-mib 200");
    refused(
        &folder,
        4,
        &line,
        &["plan.toml", "states", "MiB", "reduce counts, headings, speed modes or the lattice"],
    );
}

#[test]
fn a_short_time_ends_in_a_plan_or_in_no_answer() {
    let folder = small();
    let ran = run(&folder, &format!("{PLAN} --time-limit-s 0.000001"));
    if ran.code != Some(4) {
        ran.succeeds();
        let planned = Planned::of(&folder);
        assert!(planned.number("/lower_bound") <= planned.number("/cost"));
        assert!(planned.number("/lower_bound") <= small_planned().number("/cost"));
    }
}
