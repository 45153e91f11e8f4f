use serde_json::Value;

use crate::CROSS;
use crate::support::*;

fn estimators(folder: &tempfile::TempDir) -> Vec<Value> {
    json(folder, "scores.json")["data"]["left_out"]["estimators"].as_array().unwrap().clone()
}

#[test]
fn every_run_is_left_out_once_and_windows_are_side_by_side() {
    let folder = with(&["campaign.parquet"]);
    run(&folder, &format!("{CROSS} --out scores.json")).succeeds();
    let document = json(&folder, "scores.json");
    let data = &document["data"]["left_out"];
    assert_eq!((&data["folds"], &data["windows"], &data["samples"]), (&4.into(), &20.into(), &4000.into()));
    assert_eq!(data["differences"].as_array().unwrap().len(), 3);
    // Four recordings are too few for an interval.
    assert_eq!((&data["recommended"], data["candidates"].as_array().unwrap().len()), (&Value::Null, 4));
    let found = estimators(&folder);
    let names: Vec<&str> = found.iter().map(|e| e["name"].as_str().unwrap()).collect();
    assert_eq!(names, ["ls", "iv", "auto", "output-error"]);
    for estimator in &found {
        let sources: Vec<&Value> =
            estimator["sources"].as_array().unwrap().iter().map(|s| &s["source"]).collect();
        assert_eq!(sources.len(), 4, "{estimator}");
        let whole = estimator["errors"]["rmse_u"].as_f64().unwrap();
        let own = |s: &Value| s["errors"]["rmse_u"].as_f64().unwrap().powi(2) / 4.0;
        let mean: f64 = estimator["sources"].as_array().unwrap().iter().map(own).sum();
        assert!((whole - mean.sqrt()).abs() < 1e-12, "sources of equal length make up the whole");
    }
}

#[test]
fn folds_are_dealt_in_turns() {
    let folder = with(&["campaign.parquet"]);
    run(&folder, &format!("{} --estimator ls --out scores.json", CROSS.replace("each", "2"))).succeeds();
    assert_eq!(json(&folder, "scores.json")["data"]["left_out"]["folds"], 2);
    assert_eq!(estimators(&folder)[0]["sources"].as_array().unwrap().len(), 4);
}

#[test]
fn an_estimator_that_cannot_be_simulated_is_told_and_not_recommended() {
    let folder = with(&["dictionary.parquet"]);
    let line = "estimate --structure own --folds each --vessel vessel.toml --trajectories dictionary.parquet --runs 0,1,2 \
                --estimator ls,iv --out scores.json";
    let said = run(&folder, line).succeeds();
    let data = json(&folder, "scores.json")["data"]["left_out"].clone();
    assert_eq!(
        (&data["recommended"], &data["estimators"][0]["status"]),
        (&Value::Null, &"not identifiable".into())
    );
    assert!(data["estimators"][0]["reason"].as_str().unwrap().contains("sway"), "{said}");
}

#[test]
fn the_report_of_pooled_runs_shows_them_and_what_is_missing() {
    let folder = with(&["campaign.parquet"]);
    run(&folder, &format!("{CROSS} --estimator iv,ls --bootstrap 9 --out estimates.parquet")).succeeds();
    run(&folder, REPORT).succeeds();
    let page = String::from_utf8(bytes(&folder, "report.html")).unwrap();
    for piece in
        ["href=\"#cross-validation\"", "none recommended: ", "Parameters of yaw", "<code>ingest.json</code>"]
    {
        assert!(page.contains(piece), "{piece}");
    }
    assert!(!page.contains("NaN") && !page.contains("id=\"dictionary\""));
}
