//! Maneuvers that react to the ship in plans.

use std::ops::Range;

use serde_json::Value;
use tempfile::TempDir;

use crate::planned::*;
use crate::support::*;

/// Standard maneuvers of the vessel of Helsinki, and a motion held by feedback.
const DICTIONARY: &str = r#"inputs_from = "nominal"

[[maneuver]]
name = "zig-zag-20"
kind = "zig-zag-test"
speed_m_s = 3.0
helm = { tau3 = 120.0 }
heading_rad = 0.349
duration_s = 150.0

[[maneuver]]
name = "circle"
kind = "turning-circle"
speed_m_s = 1.5
helm = { tau3 = 200.0 }
duration_s = 420.0

[[maneuver]]
name = "crash-stop"
kind = "stop"
speed_m_s = 3.0
inputs = { tau1 = -60.0 }
duration_s = 120.0

[[maneuver]]
name = "swing"
kind = "zig-zag"
shape = "sine"
speed_m_s = 3.0
yaw_rate_amplitude_rad_s = 0.02
period_s = 90.0
duration_s = 180.0
executed = "feedback"
"#;

const SIMULATE: &str = "simulate dictionary --vessel vessel.toml --dictionary dictionary.toml --out dictionary.parquet --allow=unreached";

/// A study off Helsinki with these maneuvers of [`DICTIONARY`], once each, and `dictionary.toml` in which `from` is turned into `to`.
fn study(names: &[&str], [from, to]: [&str; 2]) -> TempDir {
    let folder = small();
    let repository = repository();
    std::fs::create_dir_all(folder.path().join("fixtures/charts")).unwrap();
    std::fs::copy(repository.join(HELSINKI_LAND), folder.path().join(HELSINKI_LAND)).unwrap();
    put(&folder, "dictionary.toml", &DICTIONARY.replace(from, to));
    let config = std::fs::read_to_string(repository.join("pipelines/helsinki/plan.toml")).unwrap();
    let config = config.replace("../../fixtures", "fixtures").replace("runs = 1536", "runs = 96");
    // By exact sensors every vessel ends every leg within its tolerance.
    let config = ["position_m = 3.0\n", "heading_deg = 1.0\n", "speed_m_s = 0.1\n"]
        .iter()
        .fold(config, |config, line| config.replacen(line, "", 1));
    let (before, rest) = config.split_once("[[maneuver]]").unwrap();
    let (_, after) = rest.split_once("[start]").unwrap();
    let uses: String =
        names.iter().map(|name| format!("[[maneuver]]\nname = \"{name}\"\ncount = 1\n\n")).collect();
    put(&folder, "plan.toml", &format!("{before}{uses}[start]{after}"));
    run(&folder, SIMULATE).succeeds();
    folder
}

const BY_PROGRAMS: &str = "plan --vessel vessel.toml --trajectories dictionary.parquet --dictionary dictionary.toml --config plan.toml \
                           --out plan.json";

/// The samples of `maneuver` on the track.
fn samples(track: &Track, maneuver: &str) -> Range<usize> {
    let own = |k: &usize| track.informative[*k] && track.maneuver[*k] == maneuver;
    let first = (0..track.t.len()).find(own).unwrap();
    first..first + (first..track.t.len()).take_while(own).count()
}

fn primitives<'a>(planned: &'a Planned, maneuver: &str) -> Vec<&'a Value> {
    let all = planned.voyage()["primitives"].as_array().unwrap().iter();
    all.filter(|own| own["maneuver"] == maneuver).collect()
}

fn spread_m(planned: &Planned, maneuver: &str) -> f64 {
    let own = primitives(planned, maneuver).into_iter();
    own.map(|own| own["spread_m"].as_f64().unwrap()).fold(0.0, f64::max)
}

#[test]
fn law_standard_maneuvers_of_a_plan_are_sailed_until_they_are_done_by_every_vessel_within_the_errors() {
    let folder = study(&["zig-zag-20", "circle", "crash-stop", "swing"], ["", ""]);
    run(&folder, BY_PROGRAMS).succeeds();
    let planned = Planned::of(&folder);
    let worst = &planned.voyage()["check"]["worst"];
    assert!(worst["searched"].as_u64().unwrap() > 100, "{worst}");
    assert!(["aground", "below_margin", "ends_astray"].iter().all(|key| worst[*key] == 0), "{worst}");
    let track = &planned.track;
    let headings = |own: Range<usize>| own.map(|k| track.pose[k][2]).collect::<Vec<f64>>();
    // The helm goes over at 20 degrees to either side.
    let own = samples(track, "zig-zag-20");
    let zig_zag = headings(own.clone());
    let most = |sign: f64| zig_zag.iter().map(|psi| sign * (psi - zig_zag[0])).fold(0.0, f64::max);
    assert!(
        [1.0, -1.0].map(most).iter().all(|turned| (0.349..0.8).contains(turned)),
        "{:?}",
        [1.0, -1.0].map(most)
    );
    for k in own.clone().skip(1) {
        let over = track.inputs[k][2] != track.inputs[k - 1][2];
        let turned = (track.pose[k][2] - zig_zag[0]).abs();
        // A sample is a second, and she turns by some degrees in it.
        assert!(!over || turned < 0.02 || (turned - 0.349).abs() < 0.1, "{k}: {turned}");
    }
    // A circle is over after one and a half turns, long before its time in the dictionary.
    let circle = samples(track, "circle");
    let turned = (track.pose[circle.end][2] - track.pose[circle.start][2]).abs();
    assert!(
        circle.len() < 300 && (turned - 3.0 * std::f64::consts::PI).abs() < 0.1,
        "{} s, {turned}",
        circle.len()
    );
    let stop = samples(track, "crash-stop");
    assert!(
        stop.len() < 60 && track.state[stop.end][0].abs() < 0.2,
        "{} s, {:?}",
        stop.len(),
        track.state[stop.end]
    );
    // Feedback keeps the vessels together that the nominal inputs take apart.
    run(&folder, &BY_PROGRAMS.replace("--dictionary dictionary.toml ", "")).succeeds();
    let open = Planned::of(&folder);
    let [held, apart] = [&planned, &open].map(|planned| spread_m(planned, "swing"));
    assert!(held < 0.2 * apart, "{held} m, {apart} m");
}

#[test]
fn law_the_cost_of_maneuvers_that_react_bounds_the_time_of_every_vessel() {
    let folder = study(&["circle"], ["", ""]);
    let seconds = format!("{BY_PROGRAMS} --set plan.cost.primary=seconds");
    run(&folder, &seconds).succeeds();
    let planned = Planned::of(&folder);
    let legs = planned.legs().iter().zip(planned.steps());
    let mut circles = 0;
    for (leg, step) in legs {
        let [cost, nominal] = [&step["cost"], &leg["duration_s"]].map(|own| own.as_f64().unwrap());
        if leg["informative"] == true {
            // With a third less moment she turns by so much more slowly.
            assert!(cost > nominal + 20.0, "{leg} {step}");
            circles += 1;
        } else {
            assert!((cost - nominal).abs() < 60.0, "{leg} {step}");
        }
    }
    assert_eq!(circles, 1);
}

#[test]
fn maneuvers_that_are_not_done_in_their_time_are_refused() {
    // The nominal vessel needs 201 s for it; with a third less moment she needs longer than 250 s.
    let line = BY_PROGRAMS;
    let folder = study(&["circle"], ["duration_s = 420.0", "duration_s = 100.0"]);
    let pieces = [
        "plan.toml: maneuver `circle`: found its change of heading not reached after 100 s",
        "lengthen its `duration_s`",
    ];
    refused(&folder, 3, line, &pieces);
    let folder = study(&["circle"], ["duration_s = 420.0", "duration_s = 250.0"]);
    let pieces = [
        "maneuver `circle`: found no leg on which all sampled vessels settle",
        "N_tau -",
        "not done within its `duration_s`",
    ];
    refused(&folder, 4, line, &pieces);
    // A helm that goes over at a heading that she does not reach.
    let folder = study(
        &["zig-zag-20"],
        ["heading_rad = 0.349\nduration_s = 150.0", "heading_rad = 1.2\nduration_s = 20.0"],
    );
    refused(&folder, 3, line, &["maneuver `zig-zag-20`: found its change of heading not reached after 20 s"]);
}

#[test]
fn the_dictionary_of_a_plan_is_that_of_its_trajectories() {
    let folder = study(&["circle"], ["", ""]);
    edit(&folder, "dictionary.toml", "tau3 = 200.0", "tau3 = 190.0");
    refused(&folder, 3, BY_PROGRAMS, &["dictionary.toml", "dictionary.parquet"]);
    refused(&folder, 1, &BY_PROGRAMS.replace("dictionary.toml", "nothing.toml"), &["nothing.toml"]);
    refused(
        &folder,
        2,
        "plan --problem problem.json --dictionary dictionary.toml --out plan.json",
        &["--dictionary"],
    );
}

#[test]
fn law_the_rest_of_a_trial_is_sailed_by_programs_too() {
    let folder = study(&["circle", "crash-stop"], ["", ""]);
    run(&folder, BY_PROGRAMS).succeeds();
    let planned = Planned::of(&folder);
    let first = planned.legs().iter().position(|leg| leg["informative"] == true).unwrap();
    let step = &planned.legs()[first + 1];
    let number = |key: &str| step[key].as_f64().unwrap();
    let mode = planned.steps()[first]["to"]["mode"].as_str().unwrap();
    let from = ["longitude_deg", "latitude_deg", "heading_deg"].map(|key| number(key).to_string()).join(",");
    let rest = BY_PROGRAMS
        .replace("plan --vessel", "plan --rest-of plan.json --vessel")
        .replace("--out plan.json", "--out rest.json");
    run(&folder, &format!("{rest} --done {} --from {from},{mode}", first + 1)).succeeds();
    let legs = json(&folder, "rest.json")["data"]["voyage"]["legs"].clone();
    let informative = |legs: &[Value]| -> Vec<(Value, f64)> {
        let own = legs.iter().filter(|leg| leg["informative"] == true);
        own.map(|leg| (leg["name"].clone(), leg["maneuver_s"].as_f64().unwrap())).collect()
    };
    let (all, left) = (informative(planned.legs()), informative(legs.as_array().unwrap()));
    assert_eq!(left.len(), 1);
    assert_eq!(left[0].0, all[1].0);
    assert!((left[0].1 - all[1].1).abs() < 3.0 && left[0].1 < 250.0, "{left:?} {all:?}");
}
