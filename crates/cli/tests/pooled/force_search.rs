//! `estimate --structure library` of a ship with forces: forces that she lacks, found and judged by recordings left out, and refusals.

use serde_json::Value;
use tempfile::TempDir;

use crate::candidates;
use crate::support::*;

const DICTIONARY: &str =
    "simulate dictionary --vessel vessel.toml --dictionary dictionary.toml --out d.parquet";
const SEARCH: &str = "estimate --structure library --vessel vessel.toml --trajectories d.parquet --allow=mixed --folds 4 \
     --fitted-window-s 40 --window-s 60";

/// The tanker KVLCC2 at 1 Hz.
fn tanker() -> String {
    let text = std::fs::read_to_string(repository().join("crates/ship/presets/kvlcc2-l7.toml")).unwrap();
    text.replace("sample_rate_hz = 10.0", "sample_rate_hz = 1.0")
}

/// Zig-zags of the ship of `text`, beside the tanker as `vessel.toml`.
fn zigzags_of(text: &str) -> TempDir {
    let folder = TempDir::new().unwrap();
    let angles = [0.1, 0.15, 0.2, 0.25, 0.3, 0.35, 0.4, 0.45, 0.5, 0.55, 0.6, 0.13];
    let zigzag = |(i, angle): (usize, &f64)| {
        format!(
            "[[maneuver]]\nname = \"z{:.0}\"\nkind = \"zig-zag-test\"\nspeed_m_s = 1.1\nhelm = {{ delta = {angle} }}\n\
             heading_rad = {angle:.4}\nto = \"starboard\"\nduration_s = 120.0\napproach = {{ n = {} }}\n",
            angle.to_degrees(),
            [10.5, 9.0, 12.0][i % 3]
        )
    };
    let all: String = angles.iter().enumerate().map(zigzag).collect();
    put(&folder, "dictionary.toml", &all);
    put(&folder, "vessel.toml", text);
    run(&folder, DICTIONARY).succeeds();
    put(&folder, "vessel.toml", &tanker());
    folder
}

/// The tanker with another force in yaw.
fn with_another() -> String {
    let more = "yaw = [\n  { parameter = \"N_more\", term = \"u v delta\", prime = 0.15, fixed = true },";
    tanker().replace("yaw = [", more)
}

fn searched(folder: &TempDir) -> Value {
    json(folder, "estimate.json")["data"]["search"].clone()
}

fn numbers(folder: &TempDir) -> Vec<String> {
    let model = json(folder, "model.json");
    let all = model["data"]["forces"]["parameters"].as_array().unwrap();
    all.iter().map(|own| own["name"].as_str().unwrap().to_owned()).collect()
}

fn mean(errors: &Value) -> f64 {
    ["fit_u", "fit_v", "fit_r"].map(|fit| errors[fit].as_f64().unwrap()).iter().sum::<f64>() / 3.0
}

#[test]
fn law_a_force_that_the_ship_lacks_is_found_and_followed_better_on_recordings_left_out() {
    let folder = zigzags_of(&with_another());
    let said = run(&folder, &format!("{SEARCH} --out estimate.json")).succeeds();
    let found = searched(&folder);
    let (forces, nested) = (&found["forces"], &found["nested"]);
    let first = &forces["found"][0];
    assert!(first["degree"] == "yaw" && first["term"] == "u v delta", "{forces}");
    assert_eq!((&forces["delivered"], &first["found_by_folds"]), (&true.into(), &4.into()), "{found}");
    assert!((first["value"].as_f64().unwrap() - 0.15).abs() < 0.05, "{first}");
    assert!(nested["base"].is_null() || mean(&nested["search"]) > mean(&nested["base"]) + 5.0, "{nested}");
    assert!(nested["margin"]["interval"][0].as_f64().unwrap() > 0.0, "{nested}");
    assert!(forces["found_cost"].as_f64().unwrap() < 0.2 * forces["base_cost"].as_f64().unwrap(), "{forces}");
    // Nothing of a ridge, and the terms of the ship that is delivered.
    assert!(found["ridge"].is_null() && nested["ridges"].as_array().unwrap().is_empty(), "{found}");
    let terms = found["terms"].as_array().unwrap();
    let added: Vec<&Value> = terms.iter().filter(|own| own["base"] == false).collect();
    assert!(added.len() == 1 && added[0]["name"] == "N_u_v_delta" && terms.len() > 10, "{terms:?}");
    assert!(numbers(&folder).contains(&"N_u_v_delta".to_owned()));
    let words = ["found: `u v delta` in yaw (in 4 of 4 folds too)", "with what was found", "better than"];
    words.iter().for_each(|word| assert!(said.stdout.contains(word), "{word}: {said}"));
    assert!(json(&folder, "model.json")["data"]["statements"].to_string().contains(words[0]));
    // The ship stands for vessel.toml, and the page shows how she was found.
    let line = "simulate dictionary --vessel model.json --dictionary dictionary.toml --out again.parquet";
    run(&folder, line).succeeds();
    run(&folder, "report --study . --results . --allow=mixed --out report.html").succeeds();
    let page = String::from_utf8(bytes(&folder, "report.html")).unwrap();
    for piece in ["The search for forces", "whole search", "Found without a fold", "4 of 4"] {
        assert!(page.contains(piece), "{piece}");
    }
}

#[test]
fn law_a_right_ship_is_delivered_as_she_was_by_any_number_of_threads() {
    let folder = zigzags_of(&tanker());
    candidates(&folder, "sway = [\"v^3 / U\", \"v |v|\"]\nyaw = [\"u v delta\", \"r |r|\"]\n");
    let line = format!("{SEARCH} --allow=mixed --out estimate.json");
    let said = run(&folder, &line).succeeds();
    let found = searched(&folder);
    assert_eq!(found["forces"]["delivered"], false);
    assert!(found["forces"]["found"].as_array().unwrap().is_empty(), "{found}");
    assert_eq!(found["nested"]["search"], found["nested"]["base"]);
    assert_eq!(found["nested"]["margin"]["interval"], serde_json::json!([0.0, 0.0]));
    assert!(said.stdout.contains("no force that the ship lacks was found; delivered: the ship as she was"));
    assert!(numbers(&folder).iter().all(|own| !own.contains("delta")), "{:?}", numbers(&folder));
    let read = || ["estimate.json", "model.json"].map(|name| bytes(&folder, name));
    let first = read();
    run(&folder, &format!("{line} --threads 1")).succeeds();
    assert!(first == read());
}

#[test]
fn what_a_search_for_forces_cannot_take_is_refused_in_one_line() {
    let folder = zigzags_of(&tanker());
    let line = |flags: &str| format!("{SEARCH} {flags} --out estimate.json");
    refused(&folder, 2, &line("--bootstrap 10"), &["--bootstrap", "structure `library`", "leave it out"]);
    let few = line("").replace("library", "few");
    refused(&folder, 2, &few, &["--structure", "`few` of a ship with forces", "own, library or average"]);
    let few = line("--runs 0,1,2");
    refused(&folder, 3, &few, &["d.parquet: recordings", "3", "at least as many as folds, 4"]);
    let few = line("--runs 0,1,2,3").replace("--folds 4", "--folds 3");
    refused(&folder, 3, &few, &["d.parquet: recordings", "without the largest of 3 folds", "at least 3"]);
    let long = line("").replace("--window-s 60", "--window-s 500");
    refused(&folder, 3, &long, &["d.parquet: windows", "no run as long as a window"]);
    candidates(&folder, "yaw = [\"u w\"]\n");
    let listed = line("--allow=mixed");
    refused(&folder, 3, &listed, &["vessel.toml: `yaw`: term `u w`", "`w`"]);
    candidates(&folder, "sway = [\"v^3 / U\"]\n");
    refused(&folder, 3, &listed, &["vessel.toml", "no term that the ship lacks", "one at least"]);
}
