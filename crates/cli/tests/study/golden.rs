//! Frozen results, and one file of every schema version that was ever released.
//!
//! `cargo test -p seatrial-cli --test study -- --ignored` writes fixtures/golden and fixtures/schema again.

use std::fs;
use std::path::PathBuf;

use serde_json::{Map, Value, json};
use study::trajectories::{Layout, TrajectoryReader};
use study::{estimates, files as study_files, scores};
use tempfile::TempDir;

use crate::support::*;

/// Name in fixtures/schema and name in a study.
const RELEASED: [(&str, &str); 7] = [
    ("trajectories-1.parquet", "validation.parquet"),
    ("moments-1.json", "moments.json"),
    ("design-2.json", "design.json"),
    ("estimate-2.json", "estimate.json"),
    ("validation-2.json", "validation.json"),
    ("estimates-1.parquet", "estimates.parquet"),
    ("scores-1.parquet", "scores.parquet"),
];

fn fixtures(part: &str) -> PathBuf {
    repository().join("fixtures").join(part)
}

/// A number of a document by its JSON pointer, and its name in the golden file.
const NUMBERS: [(&str, &str, &str); 12] = [
    ("design log det", "design.json", "/data/log_det"),
    ("design efficiency of equal shares", "design.json", "/data/efficiency/equal_shares"),
    ("design sensitivity accelerate", "design.json", "/data/sensitivities/accelerate"),
    ("moments zig-zag-fast-steep yaw M[0]", "moments.json", "/data/maneuvers/7/degrees/2/M/0"),
    (
        "moments spiral-fast surge nonstationarity",
        "moments.json",
        "/data/maneuvers/10/degrees/0/nonstationarity",
    ),
    (
        "validation optimized parameter error median",
        "validation.json",
        "/data/scored/designs/0/parameter_error/median",
    ),
    (
        "validation optimized simulation error q90",
        "validation.json",
        "/data/scored/designs/0/simulation_error/q90",
    ),
    (
        "validation random parameter error median",
        "validation.json",
        "/data/scored/designs/1/parameter_error/median",
    ),
    (
        "validation random simulation error q10",
        "validation.json",
        "/data/scored/designs/1/simulation_error/q10",
    ),
    (
        "validation practice parameter error median",
        "validation.json",
        "/data/scored/designs/2/parameter_error/median",
    ),
    (
        "validation practice simulation error q90",
        "validation.json",
        "/data/scored/designs/2/simulation_error/q90",
    ),
    ("estimate random sway condition median", "estimate.json", "/data/designs/1/degrees/1/condition_median"),
];

/// The numbers of the small study that are frozen.
fn numbers() -> Map<String, Value> {
    let folder = with(&MADE);
    let pointed = |(name, file, pointer): (&str, &str, &str)| {
        let value =
            json(&folder, file).pointer(pointer).unwrap_or_else(|| panic!("{file}: {pointer}")).clone();
        (name.to_owned(), value)
    };
    let mut all: Map<String, Value> = NUMBERS.into_iter().map(pointed).collect();
    let shares = json(&folder, "design.json")["data"]["shares"].clone();
    for (name, share) in shares.as_object().unwrap() {
        all.insert(format!("share {name}"), share.clone());
    }
    let table = craft::read(&folder.path().join("estimates.parquet"), "estimates");
    for name in ["X_u", "X_u_se", "Y_ur", "Y_ur_se", "N_uv", "N_uv_se", "condition_yaw"] {
        let place = table.schema.columns.iter().position(|c| c.name == name).unwrap();
        let column = table.blocks[0].columns[place].as_f64().unwrap();
        all.insert(format!("{name} in optimized run 0"), json!(column[0]));
    }
    all
}

#[test]
fn golden_small_study() {
    are_golden(&fixtures("golden/smoke.json"), &numbers(), 1e-9);
}

/// A study with the files of fixtures/schema under their usual names.
fn released() -> TempDir {
    let folder = written(RUNS);
    for (fixture, name) in RELEASED {
        fs::copy(fixtures("schema").join(fixture), folder.path().join(name))
            .unwrap_or_else(|e| panic!("fixtures/schema/{fixture}: {e}; `make golden` writes the first"));
    }
    folder
}

#[test]
fn golden_files_of_every_released_schema_are_read() {
    let folder = released();
    let file = |name: &str| folder.path().join(name);
    let vessel = study_files::read_vessel(&file("vessel.toml"), &mut Default::default()).unwrap();
    let layout = Layout::new(&vessel.model);
    let reader = TrajectoryReader::open(&file("validation.parquet"), &layout, vessel.sample_rate_hz).unwrap();
    assert_eq!(reader.runs(0).unwrap()[0].samples(), 1000);
    let reader = files::TableReader::open(file("estimates.parquet"), estimates::ID, 1).unwrap();
    let rows = estimates::rows(&reader, &vessel, &file("estimates.parquet"), 0).unwrap();
    assert_eq!(rows.iter().filter(|row| row.estimate.is_some()).count(), 2 * RUNS as usize);
    let reader = files::TableReader::open(file("scores.parquet"), scores::ID, 1).unwrap();
    assert_eq!(scores::rows(&reader).unwrap().len(), 2 * RUNS as usize);
    use study::documents::*;
    assert_eq!(document::<MomentsDocument>(&folder, "moments.json").data.0.maneuvers.len(), 11);
    assert_eq!(document::<DesignDocument>(&folder, "design.json").data.order.len(), 11);
    assert_eq!(document::<EstimateDocument>(&folder, "estimate.json").data.designs.len(), 2);
    assert_eq!(
        document::<ValidationDocument>(&folder, "validation.json").data.scored.unwrap().designs.len(),
        2
    );
}

#[test]
fn golden_files_of_every_released_schema_are_taken_by_the_next_stage() {
    let folder = released();
    run(&folder, REPORT).succeeds();
    run(&folder, VALIDATE).succeeds();
    run(&folder, CAMPAIGN).succeeds();
    run(&folder, DESIGN).succeeds();
    run(&folder, &MOMENTS.replace("dictionary.parquet", "validation.parquet")).succeeds();
    run(&folder, &ESTIMATE.replace("campaign.parquet", "validation.parquet")).succeeds();
}

#[test]
fn fixtures_are_small() {
    for (fixture, _) in RELEASED {
        let length = fs::metadata(fixtures("schema").join(fixture)).map_or(0, |about| about.len());
        assert!((1..200_000).contains(&length), "fixtures/schema/{fixture}: {length} bytes");
    }
}

/// Run on request only: freezes the present results of the stages.
#[test]
#[ignore = "writes fixtures/golden and fixtures/schema; `make golden` runs it"]
fn write_fixtures_again() {
    for part in ["golden", "schema"] {
        fs::create_dir_all(fixtures(part)).unwrap();
    }
    let text = serde_json::to_string_pretty(&numbers()).unwrap();
    fs::write(fixtures("golden/smoke.json"), text + "\n").unwrap();
    for (fixture, name) in RELEASED {
        fs::write(fixtures("schema").join(fixture), study().bytes(name)).unwrap();
    }
}
