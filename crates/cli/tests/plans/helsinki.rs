//! Standard maneuvers over the harbour of Helsinki: a walk on the lattice, a track at sea, on water all the way.

use std::collections::BTreeMap;

use serde_json::Value;

use crate::fleet::{Ship, advanced, turned};
use crate::geometry::{distance_m, local_m, moved, polygons};
use crate::planned::*;
use crate::support::*;

/// Both Helsinki plans and the small one.
fn all() -> [&'static Planned; 3] {
    let [eight, four] = helsinki_planned();
    [eight, four, small_planned()]
}

fn text(value: &Value) -> &str {
    value.as_str().unwrap()
}

fn pose(value: &Value) -> (i64, i64, i64, &str) {
    let number = |key: &str| value[key].as_i64().unwrap();
    (number("i"), number("j"), number("h"), text(&value["mode"]))
}

#[test]
fn the_trial_is_proved_optimal_with_8_and_with_4_headings() {
    for (planned, headings) in helsinki_planned().into_iter().zip([8, 4]) {
        let (plan, lattice) = (&planned.plan, &planned.voyage()["lattice"]);
        assert_eq!(plan["status"], "optimal");
        assert!(text(&plan["statement"]).starts_with("Proved: "), "{}", plan["statement"]);
        assert_eq!(plan["cost"], plan["lower_bound"]);
        assert_eq!(plan["cost_unit"], "basic-moves");
        assert_eq!(lattice["headings"], headings);
        assert!(lattice["nx"].as_u64() >= Some(35) && lattice["ny"].as_u64() >= Some(44), "{lattice}");
        let three: BTreeMap<String, u64> =
            ["zig-zag-20", "circle", "crash-stop", "sway-zig-zag"].map(|name| (name.to_owned(), 3)).into();
        assert_eq!(serde_json::from_value::<BTreeMap<String, u64>>(plan["counts"].clone()).unwrap(), three);
        PLANNED.iter().for_each(|name| assert!(planned.study.bytes(name).len() > 500, "{name}"));
    }
}

#[test]
fn law_steps_are_one_walk_from_start_to_goal_with_the_counts() {
    for planned in all() {
        let steps = planned.steps();
        let mut used: BTreeMap<&str, u64> = BTreeMap::new();
        for (step, leg) in steps.iter().zip(planned.legs()) {
            assert_eq!(step["action"], leg["name"]);
            if leg["informative"] == true {
                *used.entry(text(&step["action"])).or_default() += 1;
            }
        }
        assert_eq!(planned.plan["counts"], serde_json::to_value(used).unwrap());
        for pair in steps.windows(2) {
            assert_eq!(pose(&pair[0]["to"]), pose(&pair[1]["from"]));
        }
        let cost: f64 = steps.iter().map(|s| s["cost"].as_f64().unwrap()).sum();
        assert_eq!(cost, planned.number("/cost"));
        let basic = planned.legs().iter().filter(|leg| leg["informative"] == false).count();
        assert_eq!(basic as f64, cost, "basic moves cost one each");
        assert_eq!(steps.len(), planned.legs().len());
    }
    let [eight, four] = helsinki_planned();
    // South of west-south-west … of plan.toml: from heading 135 at the start to 180 at the goal.
    assert_eq!((pose(&eight.steps()[0]["from"]).2, pose(&eight.steps().last().unwrap()["to"]).2), (7, 6));
    assert_eq!(pose(&four.steps().last().unwrap()["to"]).2, 3);
    let home = small_planned().steps();
    assert_eq!(pose(&home[0]["from"]), pose(&home.last().unwrap()["to"]));
}

/// Longitude and latitude of a leg's first node, and of the goal.
fn nodes(planned: &Planned) -> Vec<[f64; 2]> {
    let number = |leg: &Value, key: &str| leg[key].as_f64().unwrap();
    planned.legs().iter().map(|leg| [number(leg, "longitude_deg"), number(leg, "latitude_deg")]).collect()
}

#[test]
fn start_and_goal_are_the_nodes_nearest_to_what_is_asked_for() {
    for planned in helsinki_planned() {
        let half_diagonal = planned.number("/voyage/lattice/cell_m") / 2.0 * 2.0_f64.sqrt() + 0.1;
        let [x, y] = local_m([24.9530, 60.1486], nodes(planned)[0]);
        assert!(x.hypot(y) <= half_diagonal, "{x} {y}");
        let [x, y] = local_m([24.985, 60.112], *planned.track.place.last().unwrap());
        assert!(x.hypot(y) <= half_diagonal + 15.0, "{x} {y}");
    }
}

#[test]
fn law_the_track_is_at_its_node_when_a_leg_begins() {
    for planned in all() {
        let (track, starts) = (&planned.track, planned.track.starts());
        assert_eq!(starts.len(), planned.legs().len() + 1);
        for (leg, (row, node)) in planned.legs().iter().zip(starts.iter().zip(nodes(planned))) {
            let [x, y] = local_m(node, track.place[*row]);
            assert!(x.hypot(y) < 12.0, "{leg}: {x} {y}");
            let off = turned(track.pose[*row][2], leg["heading_deg"].as_f64().unwrap().to_radians());
            assert!(off.abs() < 6.0_f64.to_radians(), "{leg}: {off}");
            assert_eq!(track.t[*row], leg["start_s"].as_f64().unwrap());
        }
    }
}

#[test]
fn law_a_leg_displaces_the_track_as_its_move_displaces_the_pose() {
    for planned in all() {
        let cell = planned.number("/voyage/lattice/cell_m");
        let starts = planned.track.starts();
        for (step, rows) in planned.steps().iter().zip(starts.windows(2)) {
            let [a, b] = [rows[0], rows[1]].map(|row| planned.track.pose[row]);
            let ((i, j, ..), (to_i, to_j, ..)) = (pose(&step["from"]), pose(&step["to"]));
            let off = [b[1] - a[1] - cell * (to_i - i) as f64, b[0] - a[0] - cell * (to_j - j) as f64];
            // At either end within a tenth of the cell, as `approach.tolerance_cells` says.
            assert!(off[0].hypot(off[1]) < 0.2 * cell, "{step}: {off:?}");
        }
    }
}

#[test]
fn law_informative_steps_are_primitives_of_the_list() {
    for planned in all() {
        let primitives = planned.voyage()["primitives"].as_array().unwrap();
        for (step, leg) in
            planned.steps().iter().zip(planned.legs()).filter(|(_, l)| l["informative"] == true)
        {
            let ((i, j, h, _), (to_i, to_j, to_h, _)) = (pose(&step["from"]), pose(&step["to"]));
            let own = primitives.iter().find(|p| {
                let moved = [&p["h"], &p["di"], &p["dj"], &p["to_h"]].map(|n| n.as_i64().unwrap());
                p["maneuver"] == step["action"]
                    && p["side"] == leg["side"]
                    && moved == [h, to_i - i, to_j - j, to_h]
            });
            let own = own.unwrap_or_else(|| panic!("no primitive for {step}"));
            // Turns and stops last a little longer or shorter from other ends.
            let lasts_s = [own, leg].map(|of| of["maneuver_s"].as_f64().unwrap());
            assert!((lasts_s[0] - lasts_s[1]).abs() <= 1.0 && own["fits"].as_u64() > Some(0), "{own} {leg}");
            // At least one of the sampled vessels is in the strongest current, which is not corrected in a maneuver.
            let drift =
                own["maneuver_s"].as_f64().unwrap() * planned.number("/voyage/check/unknown_current_m_s");
            assert!(own["spread_m"].as_f64().unwrap() > 0.5 * drift, "{own}");
        }
    }
}

#[test]
fn law_the_track_is_what_the_nominal_model_does_under_its_inputs() {
    for planned in all() {
        let (track, ship) = (&planned.track, Ship::new(planned.text("vessel.toml"), "nominal"));
        for (row, inputs) in track.inputs.iter().enumerate() {
            let pose = advanced(track.pose[row], track.state[row]);
            let state = ship.step(track.state[row], *inputs, [0.0; 2]);
            let off = |a: [f64; 3], b: [f64; 3]| (0..3).map(|d| (a[d] - b[d]).abs()).fold(0.0, f64::max);
            assert!(
                off(pose, track.pose[row + 1]) < 1e-9 && off(state, track.state[row + 1]) < 1e-9,
                "{row}"
            );
        }
    }
}

#[test]
fn times_of_track_and_plan_agree() {
    for planned in all() {
        let track = &planned.track;
        assert_eq!(*track.t.last().unwrap(), planned.number("/voyage/duration_s"));
        assert!(track.t.iter().enumerate().all(|(row, t)| *t == row as f64), "one sample a second");
        let informative = track.informative.iter().filter(|i| **i).count();
        assert_eq!(informative as f64, planned.number("/voyage/informative_s"));
        let maneuvers_s: f64 = planned.legs().iter().filter_map(|leg| leg["maneuver_s"].as_f64()).sum();
        assert_eq!(informative as f64, maneuvers_s, "whole maneuvers");
        let seconds: f64 = planned.legs().iter().map(|leg| leg["duration_s"].as_f64().unwrap()).sum();
        assert_eq!(seconds, planned.number("/voyage/duration_s"));
        for (stretch, leg) in
            track.stretches().into_iter().zip(planned.legs().iter().filter(|l| l["informative"] == true))
        {
            assert_eq!(leg["maneuver_start_s"].as_f64(), Some(stretch.start as f64));
            assert_eq!(leg["maneuver_s"].as_f64(), Some(stretch.len() as f64));
            assert_eq!(track.maneuver[stretch.start], text(&leg["name"]));
        }
    }
}

#[test]
fn maneuvers_ahead_begin_after_a_steady_approach_of_half_a_minute() {
    for planned in helsinki_planned() {
        let track = &planned.track;
        for stretch in track.stretches() {
            let speed = match track.maneuver[stretch.start].as_str() {
                "circle" => 1.5,
                "zig-zag-20" | "crash-stop" => 3.0,
                _ => continue,
            };
            let first =
                (0..stretch.start).rev().take_while(|row| track.step[*row] == track.step[stretch.start]);
            assert!(first.count() >= 28, "run-in of {stretch:?}");
            let [u, v, r] = track.state[stretch.start];
            assert!(
                (u - speed).abs() < 0.06 * speed && v.abs() < 0.05 && r.abs() < 0.005,
                "{stretch:?} {u} {v} {r}"
            );
        }
    }
}

/// Speed of the mode and state at the start of every leg.
fn speeds(planned: &Planned) -> impl Iterator<Item = (f64, [f64; 3])> {
    let starts = planned.track.starts();
    planned
        .legs()
        .iter()
        .zip(starts)
        .map(|(leg, row)| (leg["speed_m_s"].as_f64().unwrap(), planned.track.state[row]))
}

#[test]
fn the_vessel_is_about_as_fast_as_its_mode_under_way_when_a_leg_begins() {
    for planned in all() {
        for (wanted, [u, v, r]) in speeds(planned).filter(|(wanted, _)| *wanted > 0.0) {
            // The default tolerances of plan.toml.
            let settled = (u - wanted).abs() < 0.1 && v.abs() < 0.25 && r.abs() < 0.0075;
            assert!(settled, "{wanted}: {u} {v} {r}");
        }
    }
}

#[test]
fn the_vessel_is_at_rest_where_its_mode_is() {
    for planned in all() {
        for (_, [u, v, r]) in speeds(planned).filter(|(wanted, _)| *wanted == 0.0) {
            assert!(u.hypot(v) < 0.1 && r.abs() < 0.01, "{u} {v} {r}");
        }
    }
}

#[test]
fn every_node_and_track_point_is_in_the_area_and_on_water() {
    let land = polygons(&repository().join(HELSINKI_LAND));
    assert_eq!(land.len(), 366);
    for planned in helsinki_planned() {
        for place in planned.track.place.iter().chain(&nodes(planned)) {
            let [lon, lat] = *place;
            assert!((24.905..=25.035).contains(&lon) && (60.105..=60.170).contains(&lat), "{place:?}");
            assert!(!land.iter().any(|polygon| polygon.holds(*place)), "{place:?} is on land");
        }
    }
}

#[test]
fn oracle_the_hull_keeps_the_clearance_that_the_check_tells() {
    let land = polygons(&repository().join(HELSINKI_LAND));
    for planned in helsinki_planned() {
        let mut least = f64::INFINITY;
        for (place, pose) in planned.track.place.iter().zip(&planned.track.pose).step_by(3) {
            for corner in [[15.0, 0.0], [9.0, 4.0], [-15.0, 4.0], [-15.0, -4.0], [9.0, -4.0]] {
                least = least.min(distance_m(&land, moved(*place, pose[2], corner)));
            }
        }
        let told = planned.number("/voyage/check/clearance_m");
        assert_eq!(planned.voyage()["check"]["clear"], true);
        // The reported distance is a lower bound, up to two diagonals of raster cells (30 m) below the truth.
        assert!(told <= least + 0.5 && least < told + 85.0, "{told} of {least}");
        assert!(least >= 50.0 && planned.number("/voyage/check/shortfall_m") == 0.0, "{least}");
    }
}

#[test]
fn no_run_of_any_vessel_in_any_current_goes_aground_or_misses_what_was_proved() {
    for planned in all() {
        let check = &planned.voyage()["check"];
        let none = ["aground", "below_margin", "ends_astray"].map(|key| check[key].as_u64());
        assert_eq!((none, &check["safe"]), ([Some(0); 3], &true.into()), "{check}");
        assert!(check["clearance_quantiles_m"][0].as_f64() >= check["margin_m"].as_f64(), "{check}");
        let number = |key: &str| check[key].as_f64().unwrap();
        assert!(number("ends_astray") <= 1e-3 * number("ends") && number("tolerance_used") <= 1.0, "{check}");
        let longer = number("sailed_s") / number("proved_s") - 1.0;
        assert!(longer.abs() < 0.02 && number("sailed_s") == planned.number("/voyage/duration_s"), "{check}");
    }
    for planned in helsinki_planned() {
        let check = &planned.voyage()["check"];
        assert_eq!(check["runs"], 1536, "{check}");
        assert_eq!((&check["parameter_error"], &check["margin_m"]), (&0.35.into(), &50.0.into()), "{check}");
    }
    for planned in all() {
        let check = &planned.voyage()["check"];
        assert!(check["runs"].as_u64() >= Some(4), "{check}");
        let quantiles: Vec<f64> = serde_json::from_value(check["clearance_quantiles_m"].clone()).unwrap();
        assert!(quantiles.len() == 3 && quantiles[0] >= 0.0 && quantiles.is_sorted(), "{check}");
    }
}

#[test]
fn largest_inputs_are_those_of_the_track() {
    for planned in all() {
        for (leg, rows) in planned.legs().iter().zip(planned.track.starts().windows(2)) {
            for (k, name) in ["tau1", "tau2", "tau3"].into_iter().enumerate() {
                let own = planned.track.inputs[rows[0]..rows[1]].iter().map(|row| row[k].abs());
                assert_eq!(leg["largest_inputs"][name].as_f64(), Some(own.fold(0.0, f64::max)), "{leg}");
            }
        }
    }
}

#[test]
fn the_front_ends_with_the_counts_of_the_plan() {
    for planned in all() {
        let front = planned.voyage()["front"].as_array().unwrap();
        let last = front.last().unwrap();
        assert_eq!(last["counts"], planned.plan["counts"]);
        assert_eq!(last["cost"], planned.plan["cost"]);
        for pair in front.windows(2) {
            let [a, b] = ["cost", "log_det"].map(|key| [0, 1].map(|k| pair[k][key].as_f64().unwrap()));
            assert!(a[0] <= a[1] && b[0] < b[1], "{} {}", pair[0], pair[1]);
        }
    }
}
