//! Frozen results of the small study, pooled. `make golden` writes fixtures/golden/pooled.json again.

use std::fs;
use std::path::PathBuf;

use serde_json::{Map, Value};

use crate::support::*;
use crate::{CROSS, POOL, SELECTION, picking};

/// What it is called, in which document, and its JSON pointer.
const NUMBERS: [(&str, &str, &str); 12] = [
    ("X_u", "estimate.json", "/data/trust/degrees/0/parameters/0/estimate"),
    ("X_u standard error", "estimate.json", "/data/trust/degrees/0/parameters/0/standard_error"),
    ("X_u bootstrap", "estimate.json", "/data/trust/degrees/0/parameters/0/bootstrap_std"),
    ("X_u partial R2", "estimate.json", "/data/trust/degrees/0/parameters/0/instrument_strength"),
    ("yaw condition index", "estimate.json", "/data/trust/degrees/2/condition_index"),
    ("yaw whiteness", "estimate.json", "/data/trust/degrees/2/whiteness/statistic"),
    ("ls fit u", "scores.json", "/data/left_out/estimators/0/errors/fit_u"),
    ("iv fit v", "scores.json", "/data/left_out/estimators/1/errors/fit_v"),
    ("iv error norm", "scores.json", "/data/left_out/estimators/1/error_norm"),
    (
        "optimized error norm, median",
        "validation.json",
        "/data/picks/designs/0/overlapping/error_norm/median",
    ),
    ("optimized error norm, left out", "validation.json", "/data/picks/designs/0/left_out/error_norm/median"),
    ("random error norm, median", "validation.json", "/data/picks/designs/1/overlapping/error_norm/median"),
];

fn path() -> PathBuf {
    repository().join("fixtures/golden/pooled.json")
}

fn numbers() -> Map<String, Value> {
    let folder = picking();
    // Those that the numbers were frozen of.
    let numbered = |design| (0..RUNS).map(move |run| format!("{design}/{run}"));
    let runs: Vec<String> = ["optimized", "random"].into_iter().flat_map(numbered).collect();
    let runs = format!("--runs {}", runs.join(","));
    run(&folder, &format!("{POOL} {runs} --bootstrap 20 --out estimates.parquet")).succeeds();
    run(&folder, &format!("{CROSS} --estimator ls,iv --out scores.json")).succeeds();
    run(&folder, &format!("{SELECTION} {runs} --estimator ls --out scores.parquet")).succeeds();
    let pointed = |(name, file, pointer): (&str, &str, &str)| {
        let found = json(&folder, file);
        (name.to_owned(), found.pointer(pointer).unwrap_or_else(|| panic!("{file}: {pointer}")).clone())
    };
    NUMBERS.into_iter().map(pointed).collect()
}

#[test]
fn golden_pooled_study() {
    are_golden(&path(), &numbers(), 1e-8);
}

#[test]
#[ignore = "writes fixtures/golden/pooled.json"]
fn write_golden_pooled_study() {
    fs::write(path(), format!("{:#}\n", Value::Object(numbers()))).unwrap();
}
