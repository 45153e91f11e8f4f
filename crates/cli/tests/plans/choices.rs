//! What a user may choose: counts from a design, goals, costs, currents.

use crate::fleet::Ship;
use crate::planned::*;
use crate::support::*;

const GOAL: &str = "kind = \"home\"";

#[test]
fn law_goals_that_allow_more_cost_no_more() {
    let cost = |goal: &str| plan_small(&[(GOAL, goal)]).number("/cost");
    let south = "{ longitude_deg = 24.985, latitude_deg = 59.994, heading_deg = 180.0 }";
    let east = "{ longitude_deg = 25.015, latitude_deg = 60.0, heading_deg = 90.0, mode = \"half\" }";
    let (home, any) = (small_planned().number("/cost"), cost("kind = \"any\""));
    let one = |place: &str| cost(&format!("kind = \"places\"\nplaces = [{place}]"));
    let (south_only, east_only) = (one(south), one(east));
    let both = cost(&format!("kind = \"places\"\nplaces = [{south}, {east}]"));
    assert!(any <= home.min(south_only).min(east_only));
    assert_eq!(both, south_only.min(east_only));
    assert!(any < south_only.max(east_only), "the goals make no difference");
}

#[test]
fn a_plan_to_a_list_of_places_ends_at_one_of_them_in_its_mode() {
    let place = "{ longitude_deg = 25.015, latitude_deg = 60.0, heading_deg = 90.0, mode = \"half\" }";
    let planned = plan_small(&[(GOAL, &format!("kind = \"places\"\nplaces = [{place}]"))]);
    let end = &planned.steps().last().unwrap()["to"];
    assert_eq!((end["mode"].as_str(), end["h"].as_u64()), (Some("half"), Some(0)));
    assert!((planned.track.place.last().unwrap()[0] - 25.015).abs() < 0.0015);
}

#[test]
fn law_turns_as_secondary_never_turn_more_than_seconds_do() {
    for (goal, primary) in [
        (GOAL, "basic-moves"),
        ("kind = \"any\"", "basic-moves"),
        (
            "kind = \"places\"\nplaces = [{ longitude_deg = 25.015, latitude_deg = 60.0, heading_deg = 0.0 }]",
            "basic-moves",
        ),
    ] {
        let with = |secondary: &str| {
            let changed = format!("primary = \"{primary}\"\nsecondary = \"{secondary}\"");
            plan_small(&[(GOAL, goal), ("primary = \"basic-moves\"\nsecondary = \"seconds\"", &changed)])
        };
        let (seconds, turns, clearance) = (with("seconds"), with("turns"), with("clearance"));
        assert_eq!(seconds.number("/cost"), turns.number("/cost"));
        assert_eq!(seconds.number("/cost"), clearance.number("/cost"));
        assert!(turns.turns() <= seconds.turns(), "{} {}", turns.turns(), seconds.turns());
        assert_eq!(turns.number("/secondary/value"), turns.turns() as f64);
        // Durations on the lattice are those of legs simulated one by one; those of the whole plan differ a little.
        assert!(seconds.number("/voyage/duration_s") <= 1.1 * turns.number("/voyage/duration_s"));
        assert!(seconds.number("/secondary/value") <= 1.1 * turns.number("/voyage/duration_s"));
        for planned in [&seconds, &turns, &clearance] {
            assert_eq!(planned.plan["status"], "optimal");
            assert_eq!(planned.plan["secondary"]["name"], planned.plan["secondary"]["name"]);
        }
        assert_eq!(clearance.plan["secondary"]["name"], "clearance");
    }
}

#[test]
fn law_seconds_as_cost_take_no_longer_than_basic_moves_do() {
    for secondary in ["turns", "clearance", "seconds"] {
        let cost = format!("primary = \"seconds\"\nsecondary = \"{secondary}\"");
        let fast = plan_small(&[("primary = \"basic-moves\"\nsecondary = \"seconds\"", &cost)]);
        let few = small_planned();
        assert_eq!(fast.plan["cost_unit"], "seconds");
        assert!(fast.number("/cost") <= few.number("/secondary/value") + 1e-6, "{secondary}");
        assert_eq!(fast.number("/cost"), fast.number("/lower_bound"));
        let sea = fast.number("/voyage/duration_s");
        assert!((fast.number("/cost") - sea).abs() < 0.15 * sea, "{secondary}: {sea} at sea");
        let basic = fast.legs().iter().filter(|leg| leg["informative"] == false).count() as f64;
        assert!(basic >= few.number("/cost"), "{secondary}");
    }
}

/// `design.json` of the small study.
fn designed(folder: &tempfile::TempDir) {
    run(folder, MOMENTS).succeeds();
    run(folder, DESIGN).succeeds();
}

#[test]
fn counts_follow_from_the_designs_shares_and_the_time_for_maneuvers() {
    let folder = small_with(&[(
        "maneuver = [{ name = \"zig-zag-steep\", count = 1 }, { name = \"sway-zig-zag\", count = 1 }]",
        "informative_s = 700.0\nmaneuver = [{ name = \"zig-zag-steep\", piece_s = 60.0 }, { name = \"sway-zig-zag\", piece_s = 110.0 }]",
    )]);
    designed(&folder);
    let shares = json(&folder, "design.json")["data"]["shares"].take();
    run(&folder, &format!("{PLAN} --design design.json")).succeeds();
    let planned = Planned::of(&folder);
    // Segments of one period: 60 s, and 120 s for the requested 110 s.
    for (name, segment_s) in [("zig-zag-steep", 60.0), ("sway-zig-zag", 120.0)] {
        let expected = (shares[name].as_f64().unwrap() * 700.0 / segment_s).round();
        assert!(expected >= 1.0, "{shares}");
        assert_eq!(planned.number(&format!("/counts/{name}")), expected, "{shares}");
    }
    let efficiency = planned.number("/voyage/information/design_efficiency");
    assert!(efficiency > 0.0 && efficiency < 1.5, "{efficiency}");
    assert_eq!(planned.track.stretches().iter().map(|s| s.len() % 60).max(), Some(0));
}

#[test]
fn without_maneuvers_those_of_the_design_are_used() {
    let folder = small_with(&[
        (
            "maneuver = [{ name = \"zig-zag-steep\", count = 1 }, { name = \"sway-zig-zag\", count = 1 }]",
            "informative_s = 600.0",
        ),
        (
            "name = \"half\"\nspeed_m_s = 1.5",
            "name = \"half\"\nspeed_m_s = 1.5\n[[speed_mode]]\nname = \"full\"\nspeed_m_s = 3.0",
        ),
        ("west_deg = 24.98", "west_deg = 24.95"),
        ("east_deg = 25.02", "east_deg = 25.03"),
    ]);
    designed(&folder);
    run(&folder, &format!("{PLAN} --design design.json")).succeeds();
    let planned = Planned::of(&folder);
    let shares = json(&folder, "design.json")["data"]["shares"].take();
    for (name, seconds) in [("zig-zag-steep", 180.0), ("zig-zag-wide", 270.0), ("sway-zig-zag", 240.0)] {
        let expected = (shares[name].as_f64().unwrap() * 600.0 / seconds).round();
        let found = planned.plan["counts"].get(name).and_then(serde_json::Value::as_f64).unwrap_or(0.0);
        assert_eq!(found, expected, "{name} {shares}");
    }
}

#[test]
fn law_in_a_known_current_the_track_drifts_with_it_and_still_meets_its_nodes() {
    let current = "[known_current]\nspeed_m_s = 0.2\ntowards_deg = 60.0\n\n[start]";
    let planned = plan_small(&[("[start]", current)]);
    assert_eq!(planned.plan["status"], "optimal");
    let (track, ship) = (&planned.track, Ship::new(planned.text("vessel.toml"), "nominal"));
    let [north, east] = [0.2 * 60.0_f64.to_radians().cos(), 0.2 * 60.0_f64.to_radians().sin()];
    for (row, inputs) in track.inputs.iter().enumerate() {
        let (sin, cos) = track.pose[row][2].sin_cos();
        let state =
            ship.step(track.state[row], *inputs, [north * cos + east * sin, east * cos - north * sin]);
        assert!((0..3).all(|d| (state[d] - track.state[row + 1][d]).abs() < 1e-9), "row {row}");
    }
    let cell = planned.number("/voyage/lattice/cell_m");
    assert!(planned.legs().iter().all(|leg| leg["end_error_m"].as_f64().unwrap() < 0.2 * cell));
    assert!(planned.number("/voyage/check/clearance_m") > 0.0);
}

#[test]
fn more_headings_are_planned_too_and_every_count_once_more() {
    for headings in [8, 16] {
        let planned = plan_small(&[("headings = 4", &format!("headings = {headings}"))]);
        assert_eq!(planned.plan["status"], "optimal");
        assert_eq!(planned.number("/voyage/lattice/headings"), f64::from(headings));
        assert!(planned.steps().iter().all(|s| s["from"]["h"].as_i64() < Some(i64::from(headings))));
    }
    let twice = plan_small(&[("\"zig-zag-steep\", count = 1", "\"zig-zag-steep\", count = 2")]);
    assert_eq!(twice.number("/counts/zig-zag-steep"), 2.0);
    assert!(twice.number("/cost") >= 0.0);
    let none = plan_small(&[("\"zig-zag-steep\", count = 1", "\"zig-zag-steep\", count = 0")]);
    assert!(none.plan["counts"].get("zig-zag-steep").is_none_or(|n| n == 0), "{}", none.plan["counts"]);
}

#[test]
fn a_choice_of_engines_is_refused_with_what_to_do() {
    let line = format!("{PLAN} --engine lagrangian");
    refused(
        &small(),
        2,
        &line,
        &["'--engine'", "it is gone: leave it out, since every search is exhaustive"],
    );
}
