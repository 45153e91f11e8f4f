//! The handling of the vessel: its consequences and limits.

use crate::planned::*;
use crate::support::*;

const HANDLING: &str = "[handling]\nturn_rate_rad_s = 0.05\ncrawl_m_s = 0.5\nacceleration_m_s2 = 0.05\nresponse_s = 30.0\nlookahead_m = 60.0\n";

#[test]
fn handling_that_is_left_out_follows_from_the_vessel_and_both_are_told() {
    let planned = plan_small(&[(HANDLING, "[handling]\nturn_rate_rad_s = 0.04\n")]);
    let handling = &planned.voyage()["handling"];
    let [used, derived] = [&handling["used"], &handling["derived"]["handling"]];
    assert_eq!(used["turn_rate_rad_s"], 0.04);
    for key in ["crawl_m_s", "acceleration_m_s2", "response_s", "lookahead_m"] {
        assert_eq!(used[key], derived[key], "{handling}");
    }
    // One and a half lengths of 30 m at 1.5 m/s. Turns of four lengths' radius, and their lookahead: 2/(3√3) of it.
    assert_eq!(used["response_s"], 30.0);
    let ahead_m = 4.0 * 30.0 * 2.0 / (3.0 * 3.0_f64.sqrt());
    assert!((used["lookahead_m"].as_f64().unwrap() - ahead_m).abs() < 1e-9, "{handling}");
    assert!(derived["turn_rate_rad_s"].as_f64() != Some(0.04), "{handling}");
    assert_eq!(planned.voyage()["check"]["safe"], true);
}

#[test]
fn a_vessel_that_cannot_hold_its_track_is_refused_in_one_line() {
    let ship = |keys: &str| {
        let folder = small_with(&[]);
        edit(&folder, "vessel.toml", "unit = \"kN m\"", &format!("unit = \"kN m\"\n{keys}"));
        folder
    };
    // Hardly any yaw moment, and one that responds far too late.
    for (keys, pieces) in [
        ("range = [-1e-6, 1e-6]", ["plan.toml", "`handling.turn_rate_rad_s`", "the nominal vessel"]),
        (
            "range = [-300.0, 300.0]\nlag_s = 900.0",
            ["plan.toml", "no leg on which all sampled vessels settle", "know the parameters better"],
        ),
    ] {
        let folder = ship(keys);
        let code = if keys.contains("lag_s") { 4 } else { 3 };
        refused(&folder, code, &format!("{PLAN} --allow=mixed"), &pieces);
    }
}

#[test]
fn law_actuators_of_a_plan_take_commands_when_their_hold_ends() {
    let folder = small_with(&[]);
    let text = std::fs::read_to_string(folder.path().join("vessel.toml")).unwrap();
    put(&folder, "vessel.toml", &text.replace("unit = \"kN", "hold_s = 3.0\nunit = \"kN"));
    run(&folder, &format!("{PLAN} --allow=mixed")).succeeds();
    let planned = Planned::of(&folder);
    let voyage = planned.voyage();
    assert_eq!(voyage["check"]["safe"], true);
    // A sample is a second.
    assert_eq!(voyage["handling"]["derived"]["ability"]["lag_s"], 3.0);
    let inputs = &planned.track.inputs;
    let changed = |k: &usize| inputs[*k] != inputs[k - 1];
    assert!((1..inputs.len()).filter(changed).all(|k| k.is_multiple_of(3)));
    assert!((1..inputs.len()).filter(changed).count() > 100);
}
