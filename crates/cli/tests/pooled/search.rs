//! `estimate --structure library`: a structure found from runs, and refusals.

use std::sync::OnceLock;

use serde_json::Value;
use tempfile::TempDir;

use crate::candidates;
use crate::support::*;

/// Searches with short windows, so that few runs are enough.
const SEARCH: &str = "estimate --structure library --vessel vessel.toml --trajectories campaign.parquet --fitted-window-s 20 \
     --window-s 25 --folds 3";
const RUNS: &str = "--runs random/0,random/1,random/2,random/3,optimized/0,optimized/1";

/// A campaign with sensor noise and current of `std`.
pub fn measured(std: &str) -> TempDir {
    let folder = with(&["design.json"]);
    let campaign = std::fs::read_to_string(folder.path().join("campaign.toml")).unwrap();
    put(&folder, "campaign.toml", &campaign.replace("0.15811388300841897", std));
    run(&folder, CAMPAIGN).succeeds();
    folder
}

/// Writes the preset that vessel.toml names without some parameters.
fn without(folder: &TempDir, parameters: &[&str]) {
    let preset = include_str!("../../../ship/presets/ljungberg-model-ship.toml");
    let named = |table: &&str| parameters.iter().any(|p| table.contains(&format!("parameter = \"{p}\"")));
    let tables: Vec<&str> = preset.split("\n[[").collect();
    let kept: Vec<&str> = tables.iter().filter(|table| !named(table)).copied().collect();
    assert_eq!(kept.len() + parameters.len(), tables.len());
    put(folder, "vessel.toml", &kept.join("\n[["));
}

/// Adds `roles` of the inputs to vessel.toml, in order.
fn in_roles(folder: &TempDir, roles: &[&str]) {
    let mut text = std::fs::read_to_string(folder.path().join("vessel.toml")).unwrap();
    for (i, role) in roles.iter().enumerate().filter(|(_, role)| !role.is_empty()) {
        let name = format!("name = \"tau{}\"\n", i + 1);
        text = text.replace(&name, &format!("{name}role = \"{role}\"\n"));
    }
    put(folder, "vessel.toml", &text);
}

/// What a search finds for a ship without the linear term in surge and the quadratic one, which would replace it; and what it says.
fn lacking() -> &'static (Study, String) {
    static LACKING: OnceLock<(Study, String)> = OnceLock::new();
    LACKING.get_or_init(|| {
        let folder = measured("0.01");
        without(&folder, &["X_u", "X_uu"]);
        let said = run(&folder, &format!("{SEARCH} {RUNS} --allow=mixed --out estimate.json")).succeeds();
        (Study::of(&folder), said.stdout)
    })
}

fn mean(errors: &Value) -> f64 {
    ["fit_u", "fit_v", "fit_r"].map(|fit| errors[fit].as_f64().unwrap()).iter().sum::<f64>() / 3.0
}

#[test]
fn a_term_that_the_structure_lacks_is_made_up_for_and_one_that_it_has_costs_little() {
    let folder = measured("0.01");
    let line = format!("{SEARCH} {RUNS} --out estimate.json");
    run(&folder, &line).succeeds();
    let exact = json(&folder, "estimate.json")["data"]["search"]["nested"].clone();
    assert!(mean(&exact["search"]) > mean(&exact["base"]) - 1.0, "{exact}");
    let (lacking, said) = lacking();
    let folder = lacking.with(&["campaign.parquet", "design.json", "estimate.json", "model.json"]);
    let document = json(&folder, "estimate.json");
    let nested = &document["data"]["search"]["nested"];
    // As good as with the exact structure.
    assert!(mean(&nested["search"]) > mean(&exact["search"]) - 1.0, "{nested}");
    assert!(nested["base"].is_null() || mean(&nested["base"]) < mean(&nested["search"]) - 10.0, "{nested}");
    assert!(said.contains("mean fit"), "{said}");
    let terms = document["data"]["search"]["terms"].as_array().unwrap();
    let found = terms.iter().find(|t| t["degree"] == "surge" && t["term"] == "u").unwrap();
    assert!(found["base"] == false && found["value"].as_f64().unwrap() < 0.0, "{found}");
    let recordings = nested["recordings"].as_array().unwrap();
    assert_eq!(recordings.len(), 6);
    // The model is validated by recordings that were left out; none is as long as a stretch.
    let model = json(&folder, "model.json");
    assert_eq!(model["data"]["rejected"], false);
    // With a ridge there are no valid standard errors, and the model says so.
    assert!(model["data"]["covariance"].is_null(), "{model}");
    assert!(terms.iter().all(|term| term["low"].is_null() && term["high"].is_null()), "{terms:?}");
    let told = "held back by a ridge; predictions have bands, parameters have no errors";
    assert!(said.contains(told) && model["data"]["statements"].to_string().contains(told), "{said}");
    assert!(
        model["data"]["statements"].to_string().contains("not rejected by the recordings that were left out")
    );
    // The page shows the search.
    run(&folder, &format!("{REPORT} --allow=mixed")).succeeds();
    let page = std::fs::read_to_string(folder.path().join("report.html")).unwrap();
    for piece in ["<section id=\"search\">", "Score against the ridge", "whole search", "X_u"] {
        assert!(page.contains(piece), "{piece}");
    }
    // The delivered model is what stands in the document, and others can run it.
    run(&folder, &format!("{TRY} --model model.json")).succeeds();
    // Bands are from the errors on left-out recordings, and contain most of the fitted samples.
    let bands = json(&folder, "validation.json")["data"]["recordings"]["bands"].clone();
    for inside in ["inside_u", "inside_v", "inside_r"] {
        assert!(bands[inside].as_f64().unwrap() > 0.85, "{bands}");
    }
    let model = json(&folder, "model.json");
    let values = model["data"]["degrees"].as_array().unwrap().iter();
    let values: Vec<&Value> =
        values.flat_map(|d| d["parameters"].as_array().unwrap()).map(|p| &p["value"]).collect();
    assert_eq!(values, terms.iter().map(|t| &t["value"]).collect::<Vec<_>>());
    // A list of terms replaces the library.
    candidates(&folder, "surge = [\"u\", \"u |u|\", \"1\"]\n");
    run(&folder, &format!("{line} --allow=mixed")).succeeds();
    let listed = json(&folder, "estimate.json")["data"]["search"]["terms"].as_array().unwrap().len();
    let degrees = json(&folder, "model.json")["data"]["degrees"].clone();
    let written = degrees.as_array().unwrap().iter().map(|d| d["parameters"].as_array().unwrap().len());
    assert_eq!(listed, written.sum::<usize>());
    candidates(&folder, "surge = [\"u w\"]\n");
    refused(&folder, 3, &format!("{line} --allow=mixed"), &["vessel.toml", "`w`"]);
}

/// She never goes astern, so that |u| v is u v in every sample: no design would distinguish them either.
#[test]
fn terms_that_no_recording_tells_apart_are_fixed_and_said_and_the_next_design_does_without() {
    let folder = with(&[]);
    put(&folder, "dictionary.toml", &zig_zags((0..6).map(|i| (format!("at-{i}"), 0.7 + 0.1 * f64::from(i)))));
    candidates(&folder, "sway = [\"|u| v\", \"u v\"]\n");
    run(&folder, DICTIONARY).succeeds();
    let line = SEARCH.replace("campaign.parquet", "dictionary.parquet");
    let said = run(&folder, &format!("{line} --out estimate.json")).succeeds();
    let model = json(&folder, "model.json")["data"].clone();
    let fixed = |degree: &Value| {
        let parameters = degree["parameters"].as_array().unwrap();
        let of = |fixed: bool| parameters.iter().filter(|p| (p["fixed"] == true) == fixed).cloned().collect();
        let (fixed, free): (Vec<Value>, Vec<Value>) = (of(true), of(false));
        (fixed, free)
    };
    let of_degrees: Vec<_> = model["degrees"].as_array().unwrap().iter().map(fixed).collect();
    let [one] = &of_degrees[1].0[..] else { panic!("{model}") };
    assert!(of_degrees[0].0.is_empty() && of_degrees[2].0.is_empty() && one["value"] != 0.0, "{model}");
    let name = one["name"].as_str().unwrap();
    let told =
        format!("fixed in model.json, so that the next experiment is designed for the others: `{name}`");
    assert!(said.stdout.contains(&told) && model["statements"].to_string().contains(&told), "{said}");
    let dictionary = "simulate dictionary --model model.json --dictionary dictionary.toml --allow=beyond-range --out next.parquet";
    let moments = "moments --model model.json --trajectories next.parquet --out moments.json";
    let design = "design --moments moments.json --seed 1 --out design.json";
    for line in [dictionary, moments, design] {
        run(&folder, &format!("{line} --allow=mixed")).succeeds();
    }
    // Without that `moments` finds it, and holds it.
    let mut free = model;
    for own in free["degrees"][1]["parameters"].as_array_mut().unwrap() {
        own.as_object_mut().unwrap().remove("fixed");
    }
    unsealed(&folder, "model.json", "model.json", free);
    for line in [dictionary, moments] {
        run(&folder, &format!("{line} --allow=mixed")).succeeds();
    }
    let said = run(&folder, &format!("{design} --allow=mixed")).succeeds();
    assert!(said.stdout.contains("no maneuver excites") && said.stdout.contains(name), "{said}");
}

#[test]
fn law_the_ridge_is_chosen_on_windows_whatever_the_score_is_taken_on() {
    let folder = measured("0.01");
    let line = |flags: &str| SEARCH.replace(" --window-s 25", flags);
    let found = |flags: &str| {
        run(&folder, &format!("{} {RUNS} --out estimate.json", line(flags))).succeeds();
        json(&folder, "estimate.json")["data"]["search"].clone()
    };
    // Windows as long as those that are fitted, and whole runs, none of which diverges.
    let (windows, whole) = (found(" --window-s 20"), found(""));
    assert_eq!(windows["candidates"], whole["candidates"]);
    assert!(windows["ridge"] == whole["ridge"] && windows["nested"] != whole["nested"]);
    assert!(whole["statements"].to_string().contains("the ridge was chosen over windows"), "{whole}");
}

#[test]
fn few_terms_do_what_many_do() {
    let folder = lacking().0.with(&["campaign.parquet", "design.json", "estimate.json"]);
    let line = format!("{SEARCH} {RUNS} --allow=mixed --out estimate.json");
    let many = json(&folder, "estimate.json")["data"]["search"].clone();
    let few = line.replace("library", "few");
    run(&folder, &format!("{few} --bootstrap 2 --threads 1")).succeeds();
    let alone = std::fs::read(folder.path().join("estimate.json")).unwrap();
    run(&folder, &format!("{few} --bootstrap 2 --threads 3")).succeeds();
    assert!(
        alone == std::fs::read(folder.path().join("estimate.json")).unwrap(),
        "other bytes with other threads"
    );
    let few = json(&folder, "estimate.json")["data"]["search"].clone();
    let terms = |found: &Value| found["terms"].as_array().unwrap().clone();
    assert!(2 * terms(&few).len() < terms(&many).len(), "{few}");
    assert!(mean(&few["nested"]["search"]) > mean(&many["nested"]["search"]) - 1.0, "{few}");
    let kept = terms(&few).into_iter().find(|t| t["degree"] == "surge" && t["term"] == "u").unwrap();
    assert_eq!((&kept["base"], &kept["chosen_by_folds"]), (&false.into(), &3.into()));
    // Every search over recordings drawn again finds the term that is missing, and the base's stay.
    assert_eq!((&few["resamples"]["searches"], &few["resamples"]["failed"]), (&2.into(), &0.into()));
    assert_eq!(kept["chosen_by_resamples"], 2, "{kept}");
    let number = |value: &Value| value.as_f64().unwrap_or_else(|| panic!("{few}"));
    for term in terms(&few).into_iter().filter(|term| term["chosen_by_resamples"] != 0) {
        assert!(number(&term["low"]) <= number(&term["high"]), "{term}");
        assert!(term["base"] == false || term["chosen_by_resamples"] == 2, "{term}");
    }
    let model = json(&folder, "model.json")["data"].clone();
    let own =
        model["degrees"][0]["parameters"].as_array().unwrap().iter().find(|p| p["term"] == "u").unwrap();
    assert_eq!((&own["low"], &own["high"]), (&kept["low"], &kept["high"]));
    assert!(own["standard_error"].is_null() && model["covariance"].is_null(), "{own}");
    let said = few["statements"].to_string();
    assert!(said.contains("2 searches over recordings drawn again"), "{said}");
    run(&folder, &format!("{REPORT} --allow=mixed")).succeeds();
    let page = std::fs::read_to_string(folder.path().join("report.html")).unwrap();
    assert!(page.contains("Score against the number of terms") && page.contains("Chosen without a fold"));
    assert!(page.contains("Chosen again") && page.contains("97.5 %"));
    let sizes = few["sizes"].as_array().unwrap();
    let constants = 3;
    let chosen = sizes.iter().find(|size| size["terms"] == terms(&few).len() + constants).unwrap();
    assert!(chosen["excess"].as_f64().unwrap() <= chosen["standard_error"].as_f64().unwrap(), "{chosen}");
}

/// A search for models to be averaged, among few terms so that it is fast.
fn averaged() -> (TempDir, String) {
    static AVERAGED: OnceLock<Study> = OnceLock::new();
    let line = format!("{SEARCH} {RUNS} --allow=mixed --out estimate.json").replace("library", "average");
    let found = AVERAGED.get_or_init(|| {
        let folder = measured("0.01");
        without(&folder, &["X_u", "X_uu"]);
        in_roles(&folder, &["", "", "rudder"]);
        let terms =
            "surge = [\"u\", \"u |u|\", \"v r\"]\nsway = [\"v |v|\", \"r |r|\"]\nyaw = [\"v |v|\", \"r |r|\"]\n";
        candidates(&folder, terms);
        run(&folder, &format!("{line} --threads 3")).succeeds();
        Study::of(&folder)
    });
    (found.with(&["campaign.parquet", "design.json", "estimate.json", "model.json"]), line)
}

/// Writes `data` as an average, or as the model of one.
pub fn unsealed(folder: &TempDir, of: &str, name: &str, data: Value) {
    let mut document = json(folder, of);
    document["seal"] = Value::Null;
    document["data"] = data;
    put(folder, name, &serde_json::to_string_pretty(&document).unwrap());
}

const TRY: &str =
    "validate --trajectories campaign.parquet --window-s 25 --allow=mixed --out validation.json";

#[test]
fn several_models_are_found_averaged_and_tried_together() {
    let (folder, line) = averaged();
    let read = |name: &str| std::fs::read(folder.path().join(name)).unwrap();
    let files = || ["estimate.json", "model.json"].map(read);
    let several = files();
    let said = run(&folder, &format!("{line} --threads 1")).succeeds();
    assert!(said.stdout.contains("the average with recordings left out: fit u"), "{said}");
    assert!(several == files(), "other bytes with other threads");
    let found = json(&folder, "estimate.json")["data"]["search"].clone();
    let nested = &found["nested"]["average"];
    // The single model has the exact structure among its terms, and so have the others.
    assert!(mean(&nested["errors"]) > mean(&found["nested"]["search"]) - 2.0, "{nested}");
    assert!(nested["over_search"]["pairs"] == 6 && nested["over_base"]["pairs"] == 6, "{nested}");
    let terms = found["average"]["terms"].as_array().unwrap();
    let u = terms.iter().find(|term| term["degree"] == "surge" && term["term"] == "u").unwrap();
    let number = |value: &Value| value.as_f64().unwrap();
    assert!(u["chosen"].as_u64().unwrap() > 0 && number(&u["lowest"]) <= number(&u["mean"]), "{u}");
    let members = json(&folder, "model.json")["data"]["members"].as_array().unwrap().clone();
    // A channel stays what it is.
    assert_eq!(members[0]["model"]["inputs"][2]["role"], "rudder");
    // Seven tenths of six.
    let drawn: Vec<&Vec<Value>> = members.iter().map(|own| own["found_on"].as_array().unwrap()).collect();
    assert!(drawn.len() == 10 && drawn.iter().all(|own| own.len() == 4), "{drawn:?}");
    run(&folder, &format!("{TRY} --model model.json,model.json")).succeeds();
    let compared = json(&folder, "validation.json")["data"]["recordings"].clone();
    assert_eq!(compared["models"][0]["name"], "average of models");
    assert_eq!(compared["spread"]["models"], 10);
    assert!(number(&compared["bands"]["inside_u"]) >= number(&compared["spread"]["inside_u"]));
    run(&folder, &format!("{REPORT} --allow=mixed")).succeeds();
    let page = std::fs::read_to_string(folder.path().join("report.html")).unwrap();
    for piece in ["The average", "In so many models", "average of models", "how far the models are apart"] {
        assert!(page.contains(piece), "{piece}");
    }
    // Another seed draws others.
    run(&folder, &format!("{line} --seed 2")).succeeds();
    let others = json(&folder, "model.json")["data"]["members"].clone();
    assert!((0..10).any(|i| others[i]["found_on"] != members[i]["found_on"]), "{others}");
    // A search without an average has none.
    run(&folder, &line.replace("average", "library")).succeeds();
    assert!(json(&folder, "model.json")["data"]["members"].is_null());
}

#[test]
fn law_an_average_of_equal_models_is_that_model_and_others_are_refused() {
    let (folder, _) = averaged();
    let data = json(&folder, "model.json")["data"].clone();
    let member = data["members"][1].clone();
    let with = |change: &dyn Fn(&mut Value)| {
        let mut data = data.clone();
        change(&mut data);
        unsealed(&folder, "model.json", "changed.json", data);
    };
    let equal = |count: usize| {
        let mut member = member.clone();
        member["weight"] = (1.0 / count as f64).into();
        Value::from(vec![member; count])
    };
    with(&|data| data["members"] = equal(5));
    run(&folder, &format!("{TRY} --model changed.json")).succeeds();
    let several = json(&folder, "validation.json")["data"]["recordings"].clone();
    unsealed(&folder, "model.json", "single.json", member["model"].clone());
    run(&folder, &format!("{TRY} --model single.json")).succeeds();
    let single = json(&folder, "validation.json")["data"]["recordings"].clone();
    assert_eq!(several["models"][0]["errors"], single["models"][0]["errors"]);
    assert_eq!(several["correlations"], single["correlations"]);
    assert_eq!(several["spread"]["spread_u"], 0.0);
    let try_it = format!("{TRY} --model changed.json").replace("validation.json", "other.json");
    with(&|data| data["members"][1]["model"]["sample_rate_hz"] = 4.0.into());
    refused(&folder, 3, &try_it, &["changed.json", "data.members[1]: sampling rate", "4 Hz", "8 Hz"]);
    with(&|data| data["members"][1]["model"]["recordings"][0]["source"] = "another".into());
    refused(&folder, 3, &try_it, &["data.members[1]: recordings", "another", "one search"]);
    with(&|data| data["members"][0]["weight"] = 0.9.into());
    refused(&folder, 3, &try_it, &["`data.members[0].weight`", "0.9", "equal weights"]);
    // As averages were written before.
    put(&folder, "average.json", "{\"schema\": \"average/1\", \"seal\": null}");
    let again = ["average.json", "average/1", "model/2", "made again by: seatrial estimate"];
    refused(&folder, 3, "export --model average.json --to c --out exported/", &again);
    // Each of its models is exported.
    run(&folder, "export --model model.json --to c --out exported/").succeeds();
    assert!(["model-1", "model-2"].iter().all(|name| folder.path().join("exported").join(name).is_dir()));
}

#[test]
fn an_average_of_too_few_is_refused() {
    let folder = with(&["campaign.parquet"]);
    let line = |flags: &str| format!("{SEARCH} {RUNS} {flags} --out estimate.json");
    let few = line("").replace("library", "average").replace(",optimized/1", "");
    refused(
        &folder,
        3,
        &few,
        &["campaign.parquet", "recordings", "5", "at least 6 for `average`", "--folds"],
    );
}

#[test]
fn what_is_written_takes_no_place_of_what_is_read() {
    let (folder, line) = averaged();
    let line = line.replace("average", "library");
    let model = line.replace("vessel.toml", "model.json");
    refused(&folder, 2, &model, &["--out", "model.json", "also an input"]);
    refused(
        &folder,
        2,
        &line.replace("--out estimate.json", "--out model.json").replace("vessel.toml", "model.json"),
        &["model.json", "also an input"],
    );
    run(&folder, &format!("{TRY} --model model.json")).succeeds();
    std::fs::copy(folder.path().join("campaign.parquet"), folder.path().join("compare.parquet")).unwrap();
    let own = TRY.replace("campaign.parquet", "compare.parquet");
    refused(&folder, 2, &format!("{own} --model model.json"), &["compare.parquet", "also an input"]);
    for stage in [
        "simulate dictionary --model model.json --dictionary dictionary.toml --out model.json",
        "moments --model model.json --trajectories campaign.parquet --out model.json",
        "estimate --model model.json --trajectories campaign.parquet --out estimates.parquet",
        "estimate --structure own --model model.json --trajectories campaign.parquet --out estimates.parquet",
    ] {
        refused(&folder, 2, &format!("{stage} --allow=mixed"), &["--out", "model.json", "also an input"]);
    }
}

#[test]
fn a_search_without_an_answer_is_refused() {
    let folder = with(&["campaign.parquet"]);
    let few = format!("{SEARCH} --runs random/0,random/1 --out estimate.json");
    refused(&folder, 3, &few, &["campaign.parquet", "recordings", "2", "folds, 3", "ingest.json"]);
    let line = |flags: &str| format!("{SEARCH} {RUNS} {flags} --out estimate.json");
    let short = line("").replace("--fitted-window-s 20", "--fitted-window-s 0.01");
    refused(&folder, 2, &short, &["--fitted-window-s", "0.01"]);
    let long = line("").replace("--window-s 25", "--window-s 2500");
    refused(&folder, 3, &long, &["campaign.parquet", "windows", "--window-s"]);
}

#[test]
fn a_channel_that_cannot_be_what_it_says_is_refused() {
    let folder = with(&["campaign.parquet"]);
    let line = format!("{SEARCH} {RUNS} --allow=mixed --out estimate.json");
    for (roles, told) in [
        (&["ruder"][..], &["`ruder`", "`rudder`"][..]),
        (&["port"], &["input `tau1`, `role`", "`port` without", "as many `port` as `starboard`", "line "]),
        (&["starboard", "port", "port"], &["input `tau3`, `role`", "`port` without"]),
        (&["port", "", "starboard"], &["input `tau3`, `role`", "`N m`", "`tau1` in `N`", "one unit"]),
        (&["wind", "wind"], &["input `tau2`, `role`", "`wind`, which `tau1` is too", "one channel"]),
        (&["wind-from"], &["input `tau1`, `role`", "`wind-from` in `N`", "an angle in `rad`"]),
        (&["", "wind"], &["input `tau2`, `role`", "`wind` without a channel of its direction", "wind-from"]),
    ] {
        without(&folder, &[]);
        in_roles(&folder, roles);
        refused(&folder, 3, &line, &[&["vessel.toml: "], told].concat());
    }
}

#[test]
fn a_search_whose_best_model_is_no_better_than_the_mean_is_no_answer() {
    let folder = measured("3.0");
    // Over two samples the error of the first state is all there is.
    let line = SEARCH.replace("--window-s 25", "--window-s 0.25");
    refused(
        &folder,
        4,
        &format!("{line} {RUNS} --out estimate.json"),
        &["no better than the mean", "campaign"],
    );
}

/// A dictionary of zig-zags by name and speed.
fn zig_zags(all: impl Iterator<Item = (String, f64)>) -> String {
    let maneuver = |(name, speed): (String, f64)| {
        format!(
            "[[maneuver]]\nname = \"{name}\"\nkind = \"zig-zag\"\nshape = \"sine\"\nspeed_m_s = {speed}\n\
             yaw_rate_amplitude_rad_s = 0.03\nperiod_s = 10.0\n"
        )
    };
    format!("duration_s = 37.5\n{}", all.map(maneuver).collect::<Vec<_>>().join("\n"))
}

#[test]
fn a_fold_that_diverges_is_rejected_and_counted_never_a_number() {
    let folder = with(&[]);
    // The limit of five times the speed of the slow ones is far below that of the fast one.
    let slow = (0..5).map(|i| (format!("slow-{i}"), 0.1 + 0.005 * f64::from(i)));
    put(&folder, "dictionary.toml", &zig_zags(slow.chain([("fast".to_owned(), 1.2)])));
    run(&folder, DICTIONARY).succeeds();
    let line = SEARCH.replace("campaign.parquet", "dictionary.parquet");
    let pieces =
        ["dictionary.parquet", "candidates diverge in some fold, left out in it: `5`", "--fitted-window-s"];
    refused(&folder, 4, &format!("{line} --out estimate.json"), &pieces);
    assert!(!folder.path().join("estimate.json").exists() && !folder.path().join("model.json").exists());
    // Without it nothing is rejected.
    run(&folder, &format!("{line} --leave-out 5 --out estimate.json")).succeeds();
    let data = json(&folder, "estimate.json")["data"]["search"].clone();
    assert!(data["candidates"].as_array().unwrap().iter().all(|c| c["rejected"] == 0), "{data}");
}
