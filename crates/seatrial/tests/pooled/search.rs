//! `estimate search`: a structure found from runs, and what is refused.

use serde_json::Value;
use tempfile::TempDir;

use crate::support::*;

/// Searches with short windows, so that few runs are enough.
const SEARCH: &str = "estimate search --vessel vessel.toml --trajectories campaign.parquet --fitted-window-s 20 \
     --every-s 10 --window-s 25 --folds 3";
const RUNS: &str = "--runs random/0,random/1,random/2,random/3,optimized/0,optimized/1";

/// A campaign whose sensors and current err by `std`.
fn measured(std: &str) -> TempDir {
    let folder = with(&["design.json"]);
    let campaign = std::fs::read_to_string(folder.path().join("campaign.toml")).unwrap();
    put(&folder, "campaign.toml", &campaign.replace("0.15811388300841897", std));
    run(&folder, CAMPAIGN).succeeds();
    folder
}

/// Writes the preset that vessel.toml names without some parameters.
fn without(folder: &TempDir, parameters: &[&str]) {
    let preset = include_str!("../../../vessel/presets/ljungberg-model-ship.toml");
    let named = |table: &&str| parameters.iter().any(|p| table.contains(&format!("parameter = \"{p}\"")));
    let tables: Vec<&str> = preset.split("\n[[").collect();
    let kept: Vec<&str> = tables.iter().filter(|table| !named(table)).copied().collect();
    assert_eq!(kept.len() + parameters.len(), tables.len());
    put(folder, "vessel.toml", &kept.join("\n[["));
}

fn mean(errors: &Value) -> f64 {
    ["fit_u", "fit_v", "fit_r"].map(|fit| errors[fit].as_f64().unwrap()).iter().sum::<f64>() / 3.0
}

#[test]
fn a_term_that_the_structure_lacks_is_made_up_for_and_one_that_it_has_costs_little() {
    let folder = measured("0.01");
    let line = format!("{SEARCH} {RUNS} --out search.json");
    run(&folder, &line).succeeds();
    let exact = json(&folder, "search.json")["data"]["nested"].clone();
    assert!(mean(&exact["search"]) > mean(&exact["base"]) - 1.0, "{exact}");
    // Without its quadratic companion, which would stand for it.
    without(&folder, &["X_u", "X_uu"]);
    let said = run(&folder, &format!("{line} --allow-mixed")).succeeds();
    let document = json(&folder, "search.json");
    let nested = &document["data"]["nested"];
    // As good as with the exact structure.
    assert!(mean(&nested["search"]) > mean(&exact["search"]) - 1.0, "{nested}");
    assert!(nested["base"].is_null() || mean(&nested["base"]) < mean(&nested["search"]) - 10.0, "{nested}");
    assert!(said.stdout.contains("mean fit"), "{said}");
    let terms = document["data"]["terms"].as_array().unwrap();
    let found = terms.iter().find(|t| t["degree"] == "surge" && t["term"] == "u").unwrap();
    assert!(found["base"] == false && found["value"].as_f64().unwrap() < 0.0, "{found}");
    let recordings = nested["recordings"].as_array().unwrap();
    assert_eq!(recordings.len(), 6);
    // A list of terms takes the library's place.
    put(&folder, "terms.toml", "surge = [\"u\", \"u |u|\", \"1\"]\n");
    run(&folder, &format!("{line} --allow-mixed --terms terms.toml")).succeeds();
    let listed = json(&folder, "search.json")["data"]["terms"].as_array().unwrap().len();
    assert_eq!(
        listed,
        json(&folder, "model.json")["data"]["covariance"]["names"].as_array().unwrap().len() - 3
    );
    put(&folder, "terms.toml", "surge = [\"u w\"]\n");
    refused(&folder, 3, &format!("{line} --allow-mixed --terms terms.toml"), &["terms.toml", "`w`"]);
    run(&folder, &format!("{line} --allow-mixed")).succeeds();
    // Recordings that were left out speak for the model, which has none that is as long as a stretch.
    let model = json(&folder, "model.json");
    assert_eq!(model["data"]["rejected"], false);
    assert!(
        model["data"]["statements"].to_string().contains("not rejected by the recordings that were left out")
    );
    // The page shows the search.
    run(&folder, &format!("{REPORT} --allow-mixed")).succeeds();
    let page = std::fs::read_to_string(folder.path().join("report.html")).unwrap();
    for piece in ["<section id=\"search\">", "Score against the ridge", "whole search", "X_u"] {
        assert!(page.contains(piece), "{piece}");
    }
    // The delivered model is what stands in the document, and others can run it.
    let line =
        "validate compare --model model.json --trajectories campaign.parquet --window-s 25 --allow-mixed";
    run(&folder, &format!("{line} --out compare.json")).succeeds();
    let model = json(&folder, "model.json");
    let values = model["data"]["degrees"].as_array().unwrap().iter();
    let values: Vec<&Value> =
        values.flat_map(|d| d["parameters"].as_array().unwrap()).map(|p| &p["value"]).collect();
    assert_eq!(values, terms.iter().map(|t| &t["value"]).collect::<Vec<_>>());
}

#[test]
fn few_terms_do_what_many_do() {
    let folder = measured("0.01");
    without(&folder, &["X_u", "X_uu"]);
    let line = format!("{SEARCH} {RUNS} --allow-mixed --out search.json");
    run(&folder, &line).succeeds();
    let many = json(&folder, "search.json")["data"].clone();
    run(&folder, &format!("{line} --compact --threads 1")).succeeds();
    let alone = std::fs::read(folder.path().join("search.json")).unwrap();
    run(&folder, &format!("{line} --compact --threads 3")).succeeds();
    assert!(
        alone == std::fs::read(folder.path().join("search.json")).unwrap(),
        "other bytes with other threads"
    );
    let few = json(&folder, "search.json")["data"].clone();
    let terms = |found: &Value| found["terms"].as_array().unwrap().clone();
    assert!(2 * terms(&few).len() < terms(&many).len(), "{few}");
    assert!(mean(&few["nested"]["search"]) > mean(&many["nested"]["search"]) - 1.0, "{few}");
    let kept = terms(&few).into_iter().find(|t| t["degree"] == "surge" && t["term"] == "u").unwrap();
    assert_eq!((&kept["base"], &kept["chosen_by_folds"]), (&false.into(), &3.into()));
    run(&folder, &format!("{REPORT} --allow-mixed")).succeeds();
    let page = std::fs::read_to_string(folder.path().join("report.html")).unwrap();
    assert!(page.contains("Score against the number of terms") && page.contains("Chosen without a fold"));
    let sizes = few["sizes"].as_array().unwrap();
    let constants = 3;
    let chosen = sizes.iter().find(|size| size["terms"] == terms(&few).len() + constants).unwrap();
    assert!(chosen["excess"].as_f64().unwrap() <= chosen["standard_error"].as_f64().unwrap(), "{chosen}");
}

#[test]
fn a_search_without_an_answer_is_refused() {
    let folder = with(&["campaign.parquet"]);
    let few = format!("{SEARCH} --runs random/0,random/1 --out search.json");
    refused(&folder, 3, &few, &["campaign.parquet", "recordings", "2", "folds, 3", "--recordings"]);
    let line = |flags: &str| format!("{SEARCH} {RUNS} {flags} --out search.json");
    refused(&folder, 3, &line("--rudder delta"), &["vessel.toml", "channel `delta`"]);
    let short = line("").replace("--every-s 10", "--every-s 0.01");
    refused(&folder, 2, &short, &["--every-s", "0.01"]);
    let long = line("").replace("--window-s 25", "--window-s 2500");
    refused(&folder, 3, &long, &["campaign.parquet", "windows", "--window-s"]);
}

#[test]
fn a_search_whose_best_model_is_no_better_than_the_mean_is_no_answer() {
    let folder = measured("3.0");
    // Over two samples the error of the first state is all there is.
    let line = SEARCH.replace("--window-s 25", "--window-s 0.25");
    refused(
        &folder,
        4,
        &format!("{line} {RUNS} --out search.json"),
        &["no better than the mean", "campaign"],
    );
}

#[test]
fn a_fold_that_diverges_is_rejected_and_counted_never_a_number() {
    let folder = with(&[]);
    let maneuver = |name: &str, speed: f64| {
        format!(
            "[[maneuver]]\nname = \"{name}\"\nkind = \"zig-zag\"\nshape = \"sine\"\nspeed_m_s = {speed}\n\
             yaw_rate_amplitude_rad_s = 0.03\nperiod_s = 10.0\n"
        )
    };
    // Whatever is fitted to the slow ones, five times their speed is far below that of the fast one.
    let slow = (0..5).map(|i| maneuver(&format!("slow-{i}"), 0.1 + 0.005 * f64::from(i)));
    let all: Vec<String> = slow.chain([maneuver("fast", 1.2)]).collect();
    put(&folder, "dictionary.toml", &format!("duration_s = 37.5\n{}", all.join("\n")));
    run(&folder, DICTIONARY).succeeds();
    let line = SEARCH.replace("campaign.parquet", "dictionary.parquet");
    let pieces = ["dictionary.parquet", "candidates diverge in some fold", "--fitted-window-s"];
    refused(&folder, 4, &format!("{line} --out search.json"), &pieces);
    assert!(!folder.path().join("search.json").exists() && !folder.path().join("model.json").exists());
    // Without it nothing is rejected.
    run(&folder, &format!("{line} --leave-out 5 --out search.json")).succeeds();
    let data = json(&folder, "search.json")["data"].clone();
    assert!(data["candidates"].as_array().unwrap().iter().all(|c| c["rejected"] == 0), "{data}");
}
