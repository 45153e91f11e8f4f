use serde_json::Value;

use crate::support::*;

fn maneuvers(folder: &tempfile::TempDir, flags: &str) -> Vec<Value> {
    run(
        folder,
        &format!("moments --vessel vessel.toml --trajectories campaign.parquet {flags} --out moments.json"),
    )
    .succeeds();
    json(folder, "moments.json")["data"]["maneuvers"].as_array().unwrap().clone()
}

#[test]
fn segments_of_many_runs_are_pooled_by_maneuver() {
    let folder = with(&["campaign.parquet"]);
    let found = maneuvers(&folder, "");
    let mut names: Vec<&str> = found.iter().map(|m| m["name"].as_str().unwrap()).collect();
    names.sort_unstable();
    names.dedup();
    assert_eq!(names.len(), found.len());
    assert_eq!(found.iter().map(|m| m["samples"].as_u64().unwrap()).sum::<u64>(), 3 * RUNS * 1000);
    for (d, _) in ["surge", "sway", "yaw"].iter().enumerate() {
        let matrix = found[0]["degrees"][d]["M"].as_array().unwrap();
        assert!((matrix.last().unwrap().as_f64().unwrap() - 1.0).abs() < 1e-12);
    }
}

#[test]
fn a_fitted_nominal_model_makes_other_instruments() {
    let folder = with(&["campaign.parquet"]);
    let given = maneuvers(&folder, "--nominal given");
    let fitted = maneuvers(&folder, "--nominal least-squares");
    assert_eq!(given, maneuvers(&folder, ""));
    assert_ne!(given[0]["degrees"][0]["M"], fitted[0]["degrees"][0]["M"]);
}
