//! Measured logs that are not part of the project: `../shared/data` next to it. Without them these tests say so and
//! pass.

use std::process::Command;

use serde_json::{Value, json};
use tempfile::TempDir;

use crate::pick;
use crate::support::*;

/// A folder with the study's trajectories; `None` without the logs.
fn ingested(study: &str, data: &str) -> Option<TempDir> {
    let logs = repository().join("../shared/data").join(data);
    if !logs.is_dir() {
        eprintln!("skipped: there is no {}", logs.display());
        return None;
    }
    let folder = tempfile::tempdir().unwrap();
    let pipeline = repository().join("pipelines").join(study);
    std::fs::copy(pipeline.join("vessel.toml"), folder.path().join("vessel.toml")).unwrap();
    let mut ingest = Command::new(SEATRIAL);
    ingest.current_dir(&folder).args([
        "ingest",
        "--vessel",
        "vessel.toml",
        "--out",
        "trajectories.parquet",
        "--quiet",
        "--logs",
    ]);
    let status = ingest.arg(logs).arg("--config").arg(pipeline.join("ingest.toml")).output().unwrap().status;
    assert!(status.success());
    Some(folder)
}

const LOGGED: &str = "--vessel vessel.toml --trajectories trajectories.parquet";

fn fits(folder: &TempDir, name: &str) -> [f64; 3] {
    let document = json(folder, "scores.json");
    let all = document["data"]["left_out"]["estimators"].as_array().unwrap();
    let own = all.iter().find(|e| e["name"] == name).unwrap();
    ["fit_u", "fit_v", "fit_r"].map(|fit| own["errors"][fit].as_f64().unwrap())
}

#[track_caller]
fn at_least(found: [f64; 3], bounds: [f64; 3]) {
    assert!((0..3).all(|d| found[d] >= bounds[d]), "{found:?} against {bounds:?}");
}

#[test]
fn recordings_left_out_of_the_esso_osaka_are_followed_better_than_the_baseline() {
    let Some(folder) = ingested("esso-osaka", "esso_osaka") else { return };
    let line = format!(
        "estimate --structure own --folds each {LOGGED} --window-s 100 \
         --estimator ls,iv,output-error --out scores.json"
    );
    let said = run(&folder, &line).succeeds();
    let data = json(&folder, "scores.json")["data"]["left_out"].clone();
    assert_eq!((&data["folds"], &data["candidates"][0]), (&23.into(), &"output-error".into()));
    // The difference between the estimators is within chance: 23 recordings cannot distinguish them.
    assert_eq!((&data["recommended"], data["candidates"].as_array().unwrap().len()), (&Value::Null, 3));
    assert!(said.stdout.contains("none recommended: output-error (fit u "), "{said}");
    for estimator in ["ls", "iv", "output-error"] {
        at_least(fits(&folder, estimator), [71.0, 71.0, 62.0]);
    }
}

#[test]
fn the_optimized_selection_of_the_esso_osaka_is_more_than_twice_as_good_as_a_random_one() {
    let Some(folder) = ingested("esso-osaka", "esso_osaka") else { return };
    run(&folder, &format!("moments {LOGGED} --estimator ls --out moments.json")).succeeds();
    run(
        &folder,
        "design --moments moments.json --segments 6 --segment-samples 60 --available ingest.json --out design.json",
    )
    .succeeds();
    for (estimator, bound) in [("ls", 1.1), ("iv", 0.8)] {
        let line = format!("validate {LOGGED} --design design.json --estimator {estimator}");
        run(&folder, &format!("{line} --out scores.parquet")).succeeds();
        let data = json(&folder, "validation.json")["data"]["picks"].clone();
        let q90 = |i: usize| {
            data["designs"][i]["overlapping"]["error_norm"]["q90"].as_f64().unwrap_or(f64::INFINITY)
        };
        assert!(q90(0) < bound && q90(0) <= 0.5 * q90(1), "{estimator}: {} {}", q90(0), q90(1));
        let share = |i: usize| data["designs"][i]["degenerate_share"].as_f64().unwrap();
        assert!(share(0) < 0.01 && share(1) > 0.05, "{estimator}: {} {}", share(0), share(1));
    }
}

/// Without the terms that the paper's structure lacks, instruments simulated over a minute lose sway and yaw.
#[test]
fn poor_instruments_are_told() {
    let Some(folder) = ingested("esso-osaka", "esso_osaka") else { return };
    let kept = ["u", "u |u|", "v r", "n |n|", "v", "u r", "u |u| delta", "r", "u v"];
    let text = std::fs::read_to_string(folder.path().join("vessel.toml")).unwrap();
    let wanted = |block: &&str| {
        let term = block.split("term = \"").nth(1).and_then(|rest| rest.split('"').next());
        term.is_none_or(|term| kept.contains(&term))
    };
    let blocks: Vec<&str> = text.split("\n[[").filter(wanted).collect();
    put(&folder, "vessel.toml", &blocks.join("\n[["));
    run(&folder, &format!("moments {LOGGED} --estimator ls --out moments.json")).succeeds();
    run(&folder, "design --moments moments.json --segments 6 --segment-samples 60 --out design.json")
        .succeeds();
    pick(&folder, json!({"zigzag/fast": 4, "berthing/slow": 1, "turning/medium": 1}));
    let line = format!("validate {LOGGED} --design picks.json");
    let ran = run(&folder, &format!("{line} --estimator iv --out scores.parquet")).succeeds();
    assert!(ran.stdout.contains("poor instruments: simulated"), "{ran}");
    let data = json(&folder, "validation.json")["data"]["picks"].clone();
    let said: Vec<&str> = data["statements"].as_array().unwrap().iter().filter_map(Value::as_str).collect();
    assert!(said.iter().any(|s| s.starts_with("poor instruments") && s.contains("r to ")), "{said:?}");
    for design in data["designs"].as_array().unwrap() {
        assert!(design["degenerate_share"].as_f64().unwrap() > 0.3, "{design}");
    }
    run(&folder, &format!("{line} --estimator ls --out scores.parquet")).succeeds();
    let data = json(&folder, "validation.json")["data"]["picks"].clone();
    assert!(data["designs"][0]["overlapping"]["error_norm"]["q90"].as_f64().unwrap() < 1.3);
}

#[test]
fn surge_of_the_kvlcc2_is_not_identifiable_by_instruments() {
    let Some(folder) = ingested("kvlcc2", "kvlcc2_hsva") else { return };
    for flags in ["", "--part-s 100", "--part-s 30"] {
        let line =
            format!("estimate --structure own {LOGGED} --estimator iv --nominal least-squares {flags}");
        run(&folder, &format!("{line} --out estimates.parquet")).succeeds();
        let degrees = json(&folder, "estimate.json")["data"]["trust"]["degrees"].clone();
        let status: Vec<&Value> = degrees.as_array().unwrap().iter().map(|d| &d["status"]).collect();
        assert_eq!(status, ["not identifiable", "identified", "identified"], "{flags}");
        let reason = degrees[0]["reason"].as_str().unwrap();
        for piece in [
            "surge: `thrust` (hardly varies",
            "constant: `n` at 10.2295 1/s",
            "cannot be told from the intercept",
        ] {
            assert!(reason.contains(piece), "{flags}: {reason}");
        }
        assert!(degrees[0]["parameters"].as_array().unwrap().iter().all(|p| p["estimate"].is_null()));
    }
}

/// No known kind of noise describes the errors of a wrong model.
#[test]
fn where_nobody_asks_for_an_estimator_logs_without_a_known_noise_get_the_one_that_predicts_best() {
    let Some(folder) = ingested("kvlcc2", "kvlcc2_hsva") else { return };
    let few = ["05_01", "10_01", "15_01", "20_05"].map(|name| format!("kvlcc2_hsva_Z_{name}")).join(",");
    let line = format!("estimate --structure own {LOGGED} --runs {few} --nominal least-squares");
    let said = run(&folder, &format!("{line} --out estimates.parquet")).succeeds();
    assert!(said.stdout.contains("output-error from"), "{said}");
    let trust = json(&folder, "estimate.json");
    assert_eq!(trust["settings"]["estimator"], "output-error", "{trust}");
    assert!(
        trust["data"]["trust"]["statements"].to_string().contains("no noise known here describes the errors")
    );
}

#[test]
fn no_single_run_of_the_kvlcc2_is_answered_by_instruments() {
    let Some(folder) = ingested("kvlcc2", "kvlcc2_hsva") else { return };
    let pieces = ["13 runs", "surge: `thrust` (hardly varies", "cannot be told from the intercept"];
    refused(
        &folder,
        4,
        &format!("estimate --fit each {LOGGED} --estimator iv --out estimates.parquet"),
        &pieces,
    );
    run(&folder, &format!("estimate --fit each {LOGGED} --estimator ls --out estimates.parquet")).succeeds();
}

#[test]
fn the_method_of_least_error_for_the_kvlcc2_reaches_the_baseline() {
    let Some(folder) = ingested("kvlcc2", "kvlcc2_hsva") else { return };
    let line = format!(
        "estimate --structure own --folds each {LOGGED} --estimator output-error,ls,iv,auto --part-s 100 --out scores.json"
    );
    run(&folder, &line).succeeds();
    let data = json(&folder, "scores.json")["data"]["left_out"].clone();
    assert_eq!(data["candidates"], serde_json::json!(["output-error", "ls"]));
    let auto = data["differences"].as_array().unwrap().iter().find(|d| d["estimator"] == "auto").unwrap();
    assert!(auto["interval"][0].as_f64().unwrap() > 0.0, "{auto}");
    at_least(fits(&folder, "output-error"), [66.0, 73.0, 76.0]);
}

#[test]
fn a_structure_found_for_the_kvlcc2_follows_runs_that_were_left_out_of_the_search() {
    let Some(folder) = ingested("kvlcc2", "kvlcc2_hsva") else { return };
    // One run left out at a time.
    let line = format!("estimate --structure library {LOGGED} --window-s 100 --folds 13");
    let said = run(&folder, &format!("{line} --out estimate.json")).succeeds();
    let nested = json(&folder, "estimate.json")["data"]["search"]["nested"].clone();
    let fits = |of: &str| ["fit_u", "fit_v", "fit_r"].map(|fit| nested[of][fit].as_f64().unwrap());
    at_least(fits("search"), [94.0, 86.0, 88.0]);
    at_least([0, 1, 2].map(|d| fits("search")[d] - fits("base")[d]), [10.0; 3]);
    assert!(said.stdout.contains("better than the base structure"), "{said}");
}

#[test]
fn zig_zags_of_one_degree_are_outside_the_range_of_a_model_of_wider_ones() {
    let Some(folder) = ingested("kvlcc2", "kvlcc2_hsva") else { return };
    let small = ["05_01", "10_01", "15_01"].map(|name| format!("kvlcc2_hsva_Z_{name}")).join(",");
    let line = format!(
        "estimate --structure own {LOGGED} --estimator ls --leave-out {small} --out estimates.parquet"
    );
    run(&folder, &line).succeeds();
    let compared = |runs: &str| {
        let line = "validate --model model.json --trajectories trajectories.parquet";
        let said = run(&folder, &format!("{line} --runs {runs} --out validation.json")).succeeds();
        let data = json(&folder, "validation.json")["data"]["recordings"].clone();
        (data["validity"].clone(), said.stdout)
    };
    // No channel leaves its range, but the ship yaws and sways less than in any minute that was fitted.
    for name in ["05_01", "10_01", "15_01"] {
        let (validity, said) = compared(&format!("kvlcc2_hsva_Z_{name}"));
        assert!(validity["outside"].as_u64().unwrap() >= 1, "{name}: {validity}");
        let channels = validity["channels"].as_array().unwrap();
        let below =
            |state: &str| channels.iter().any(|c| c["name"] == state && c["below"].as_u64() > Some(0));
        assert!(below("v") && below("r"), "{name}: {validity}");
        assert!(said.contains("outside the range of validity in "), "{said}");
    }
    let (validity, said) = compared("kvlcc2_hsva_Z_20_05");
    assert_eq!(validity["outside"], 0, "{validity}");
    assert!(!said.contains("outside the range of validity"), "{said}");
}

#[test]
fn the_report_of_measured_logs_shows_what_they_tell() {
    let Some(folder) = ingested("kvlcc2", "kvlcc2_hsva") else { return };
    let recorded = format!("{LOGGED} --nominal least-squares --part-s 100");
    let flags = "--estimator iv,ls --bootstrap 20 --folds 3 --out estimates.parquet";
    run(&folder, &format!("estimate --structure own {recorded} {flags}")).succeeds();
    run(&folder, REPORT).succeeds();
    let page = String::from_utf8(bytes(&folder, "report.html")).unwrap();
    for piece in [
        "Report on measured logs",
        "<section id=\"cross-validation\">",
        "<section id=\"trust\">",
        "<section id=\"logs\">",
        "Z_35_05",
        "cannot be told from the intercept",
        "Logged velocities against position and heading",
    ] {
        assert!(page.contains(piece), "{piece}");
    }
    assert!(!page.contains("<section id=\"dictionary\">") && !page.contains("class=\"missing\""));
}

/// The next trial of a ship whose logs are published, from its model to its plan.
fn next_trial(study: &str, data: &str) {
    let Some(folder) = ingested(study, data) else { return };
    let pool = format!("estimate --structure own {LOGGED} --estimator ls");
    run(&folder, &format!("{pool} --out estimates.parquet")).succeeds();
    for entry in std::fs::read_dir(repository().join("pipelines").join(study).join("next")).unwrap() {
        let entry = entry.unwrap();
        std::fs::copy(entry.path(), folder.path().join(entry.file_name())).unwrap();
    }
    let simulate = "simulate dictionary --vessel model.json --dictionary dictionary.toml";
    let few = "--set dictionary.generate.candidates=100";
    let said = run(&folder, &format!("{simulate} {few} --out dictionary.parquet")).succeeds().stdout;
    assert!(!said.contains("wind_x below"), "calm is what vessel.toml asks for: {said}");
    let moments = "moments --vessel model.json --trajectories dictionary.parquet --campaign campaign.toml";
    run(&folder, &format!("{moments} --estimator output-error --out moments.json")).succeeds();
    let design = "design --moments moments.json --for output-error --duration-s 1200";
    run(&folder, &format!("{design} --out design.json")).succeeds();
    let plan =
        "plan --vessel model.json --trajectories dictionary.parquet --design design.json --config plan.toml";
    let short = "--set plan.informative_s=480 --set plan.safety.runs=24";
    run(&folder, &format!("{plan} {short} --out plan.json")).succeeds();
    assert_eq!(json(&folder, "plan.json")["data"]["voyage"]["check"]["aground"], 0);
    let (model, design) = (json(&folder, "model.json"), json(&folder, "design.json"));
    let errors = design["data"]["covariance"]["standard_errors"].as_object().unwrap();
    assert!(errors.values().all(|error| error.as_f64().unwrap() > 0.0), "{errors:?}");
    // Wind is not simulated: its parameters keep the values from the logs.
    assert!(errors.contains_key("N_uudelta") && !errors.keys().any(|name| name.contains("wind")));
    let made = craft::read(&folder.path().join("dictionary.parquet"), "trajectories");
    for channel in model["data"]["inputs"].as_array().unwrap() {
        let covered = model["data"]["covered"].as_array().unwrap();
        let covered = covered.iter().find(|own| own["name"] == channel["name"]).unwrap();
        let ends = ["low", "high"].map(|end| covered[end].as_f64().unwrap());
        let place = made.schema.columns.iter().position(|c| c.name == channel["name"].as_str().unwrap());
        let values = made.blocks.iter().flat_map(|block| block.columns[place.unwrap()].as_f64().unwrap());
        let (low, high) = values
            .filter(|value| value.is_finite())
            .fold((f64::INFINITY, -f64::INFINITY), |(low, high), x| (low.min(*x), high.max(*x)));
        let room = 0.05 * (ends[1] - ends[0]);
        assert!(low >= ends[0] - room && high <= ends[1] + room, "{channel}: {low} to {high}, not {ends:?}");
    }
}

#[test]
fn the_next_trial_of_a_logged_ship_is_designed_from_its_model_within_what_the_logs_cover() {
    next_trial("kvlcc2", "kvlcc2_hsva");
}

#[test]
#[ignore = "long: `make nightly` runs it"]
fn the_next_trial_of_a_model_ship_is_designed_from_her_logs() {
    next_trial("esso-osaka", "esso_osaka");
}
