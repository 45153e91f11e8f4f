//! Figures of merit of logs, through the binaries: cases of `../shared/cases-2`, without which these tests say so and pass, and a log
//! that is simulated here.

use serde_json::Value;
use tempfile::TempDir;

use crate::support::*;

const INGEST: &str = "ingest --config ingest.toml --vessel vessel.toml --logs . --out t.parquet";
const MERIT: &str =
    "validate merit --vessel vessel.toml --trajectories t.parquet --length-m 100 --out merit.json";

/// A copy of a case, read by `ingest`.
fn case(name: &str) -> Option<TempDir> {
    let own = repository().join("../shared/cases-2").join(name);
    if !own.is_dir() {
        eprintln!("skipped: there is no {}", own.display());
        return None;
    }
    let folder = tempfile::tempdir().unwrap();
    for entry in std::fs::read_dir(own).unwrap() {
        let path = entry.unwrap().path();
        std::fs::write(folder.path().join(path.file_name().unwrap()), std::fs::read(&path).unwrap()).unwrap();
    }
    run(&folder, INGEST).succeeds();
    Some(folder)
}

/// The only maneuver of its figures, with and without the dictionary, which are the same.
fn measured(folder: &TempDir) -> Value {
    // Of a zig-zag it is 20° to six places.
    let text = std::fs::read_to_string(folder.path().join("dictionary.toml")).unwrap();
    put(folder, "dictionary.toml", &text.replace("0.349066", &20_f64.to_radians().to_string()));
    let found = [" --dictionary dictionary.toml", ""].map(|dictionary| {
        run(folder, &format!("{MERIT}{dictionary}")).succeeds();
        json(folder, "merit.json")["data"]["maneuvers"][0].clone()
    });
    assert_eq!(found[0]["figures"], found[1]["figures"]);
    assert_eq!(found[0]["kind"], found[1]["kind"]);
    found[0].clone()
}

#[track_caller]
fn is(found: &Value, key: &str, figures: &[(&str, f64)], most: f64) {
    for (name, expected) in figures {
        let own = found["figures"].as_array().unwrap().iter().find(|own| own["name"] == *name).unwrap();
        assert!((own[key].as_f64().unwrap() - expected).abs() < most, "{own}, expected {expected}");
    }
}

fn remarks(found: &Value) -> String {
    found["remarks"]
        .as_array()
        .into_iter()
        .flatten()
        .map(|own| own.as_str().unwrap())
        .collect::<Vec<_>>()
        .join("; ")
}

const SWINGS: [(&str, f64); 2] = [("overshoot_1", 11.09), ("overshoot_2", 12.87)];

#[test]
fn a_zig_zag_begins_where_its_helm_moves_after_a_long_approach() {
    let Some(folder) = case("33-zigzag-long-approach") else { return };
    is(&measured(&folder), "value", &SWINGS, 0.05);
}

#[test]
fn a_zig_zag_to_the_other_side_than_the_dictionary_says_is_measured_to_that_side() {
    let Some(folder) = case("37-zigzag-other-side") else { return };
    let found = measured(&folder);
    is(&found, "value", &SWINGS, 0.05);
    assert_eq!(found["sailed"], "zig-zag 20°/20°, to port first");
    assert!(remarks(&found).contains("she turned to port first, the dictionary says starboard"), "{found}");
}

const CIRCLE: [(&str, f64); 3] = [("advance", 3.7209), ("transfer", 1.9748), ("tactical_diameter", 3.6442)];

#[test]
fn an_advance_is_measured_from_the_place_of_the_order() {
    let Some(folder) = case("42-circle-long-approach") else { return };
    is(&measured(&folder), "value", &CIRCLE, 0.005);
}

#[test]
fn a_circle_in_a_current_is_corrected_for_it_and_said_to_drift() {
    let Some(folder) = case("43-circle-in-current") else { return };
    let found = measured(&folder);
    is(&found, "corrected", &CIRCLE, 0.01);
    is(&found, "value", &[("tactical_diameter", 4.69)], 0.01);
    assert!(remarks(&found).contains("the track drifts at 0.80 m/s to 090°"), "{found}");
    let told = run(&folder, MERIT).succeeds().stdout;
    assert!(told.contains("the track drifts at 0.80 m/s"), "{told}");
}

#[test]
fn a_circle_with_another_helm_has_no_limit_beside_it() {
    let Some(folder) = case("49-circle-20-judged-as-35") else { return };
    let found = measured(&folder);
    is(&found, "value", &[("advance", 5.2202), ("tactical_diameter", 6.6487)], 0.005);
    assert!(found["figures"].as_array().unwrap().iter().all(|own| own["most"].is_null()), "{found}");
    let told = remarks(&found);
    assert!(
        told.contains("the helm was 20.0°, the dictionary says 35.0°") && told.contains("35° or the most"),
        "{told}"
    );
}
