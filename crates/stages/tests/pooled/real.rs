//! Measured logs that are not part of the project: `../shared/data` beside it. Without them these tests say so and pass.

use std::process::Command;

use serde_json::Value;
use tempfile::TempDir;

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
    let mut ingest = Command::new(env!("CARGO_BIN_EXE_ingest"));
    ingest.current_dir(&folder).args([
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
    let document = json(folder, "crossval.json");
    let all = document["data"]["estimators"].as_array().unwrap();
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
        "validate cross {LOGGED} --recordings ingest.json --nominal least-squares --window-s 100 \
         --estimators ls,iv,output-error --out crossval.json"
    );
    run(&folder, &line).succeeds();
    let data = json(&folder, "crossval.json")["data"].clone();
    assert_eq!((&data["folds"], &data["recommended"]), (&23.into(), &"output-error".into()));
    for estimator in ["iv", "output-error"] {
        at_least(fits(&folder, estimator), [71.0, 71.0, 62.0]);
    }
}

#[test]
fn the_optimized_selection_of_the_esso_osaka_is_more_than_twice_as_good_as_a_random_one() {
    let Some(folder) = ingested("esso-osaka", "esso_osaka") else { return };
    run(&folder, &format!("moments {LOGGED} --instruments regressors --out moments.json")).succeeds();
    run(&folder, "design --moments moments.json --segments 6 --segment-samples 60 --out design.json")
        .succeeds();
    run(&folder, &format!("validate selection {LOGGED} --design design.json --estimator ls --out s.parquet"))
        .succeeds();
    let data = json(&folder, "selection.json")["data"].clone();
    let q90 =
        |i: usize| data["designs"][i]["overlapping"]["error_norm"]["q90"].as_f64().unwrap_or(f64::INFINITY);
    assert!(q90(0) < 1.1 && q90(0) <= 0.5 * q90(1), "{} {}", q90(0), q90(1));
    let share = |i: usize| data["designs"][i]["degenerate_share"].as_f64().unwrap();
    assert!(share(0) < 0.01 && share(1) > 0.05, "{} {}", share(0), share(1));
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
    let line = format!("validate selection {LOGGED} --counts zigzag/fast=4,berthing/slow=1,turning/medium=1");
    run(&folder, &format!("{line} --estimator iv --nominal least-squares --out s.parquet")).succeeds();
    let data = json(&folder, "selection.json")["data"].clone();
    let said: Vec<&str> = data["statements"].as_array().unwrap().iter().filter_map(Value::as_str).collect();
    assert!(said.iter().any(|s| s.starts_with("poor instruments") && s.contains("r to ")), "{said:?}");
    for design in data["designs"].as_array().unwrap() {
        assert!(design["degenerate_share"].as_f64().unwrap() > 0.3, "{design}");
    }
    run(&folder, &format!("{line} --estimator ls --out s.parquet")).succeeds();
    let data = json(&folder, "selection.json")["data"].clone();
    assert!(data["designs"][0]["overlapping"]["error_norm"]["q90"].as_f64().unwrap() < 1.3);
}

#[test]
fn surge_of_the_kvlcc2_is_not_identifiable_by_instruments_and_the_recommended_method_reaches_the_baseline() {
    let Some(folder) = ingested("kvlcc2", "kvlcc2_hsva") else { return };
    run(&folder, &format!("estimate --pool {LOGGED} --nominal least-squares --out estimates.parquet"))
        .succeeds();
    let degrees = json(&folder, "trust.json")["data"]["degrees"].clone();
    let status: Vec<&Value> = degrees.as_array().unwrap().iter().map(|d| &d["status"]).collect();
    assert_eq!(status, ["not identifiable", "identified", "identified"]);
    let reason = degrees[0]["reason"].as_str().unwrap();
    assert!(reason.contains("hardly varies") && reason.contains("the intercept"), "{reason}");
    assert!(degrees[0]["parameters"].as_array().unwrap().iter().all(|p| p["estimate"].is_null()));
    let line = format!("validate cross {LOGGED} --nominal least-squares --part-s 100 --out crossval.json");
    run(&folder, &line).succeeds();
    assert_eq!(json(&folder, "crossval.json")["data"]["recommended"], "output-error");
    at_least(fits(&folder, "output-error"), [66.0, 73.0, 76.0]);
}
