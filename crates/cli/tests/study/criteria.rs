//! Availability, exact counts and criteria of the covariance, through the binaries.

use std::sync::OnceLock;

use serde_json::Value;
use tempfile::TempDir;

use crate::support::*;

const EXPECTED: &str = "moments --vessel vessel.toml --trajectories dictionary.parquet --campaign campaign.toml --out moments.json";

/// A folder with moments that expect disturbances.
fn folder() -> TempDir {
    static MADE: OnceLock<Study> = OnceLock::new();
    MADE.get_or_init(|| Study::make(2, &[DICTIONARY, EXPECTED])).with(&["dictionary.parquet", "moments.json"])
}

fn data(folder: &TempDir) -> Value {
    json(folder, "design.json")["data"].clone()
}

fn sum(of: &Value) -> f64 {
    of.as_object().unwrap().values().map(|w| w.as_f64().unwrap()).sum()
}

fn refused(folder: &TempDir, code: i32, line: &str, pieces: &[&str]) {
    run(folder, line).refuses(code, pieces);
    assert!(!folder.path().join("design.json").exists(), "{line}");
}

#[test]
fn every_criterion_makes_its_own_value_smallest() {
    let folder = folder();
    let names = ["d", "a", "a-relative"];
    let designs = names.map(|name| {
        run(&folder, &format!("{DESIGN} --criterion {name} --relative-to value --duration-s 125")).succeeds();
        data(&folder)
    });
    for (name, design) in names.iter().zip(&designs) {
        assert_eq!(design["status"], "stationary", "{name}: {}", design["statement"]);
        assert_eq!(design["covariance"]["name"], *name);
        assert_eq!(design["covariance"]["samples"], 1000);
        assert!((sum(&design["shares"]) - 1.0).abs() < 1e-9);
        let p = design["dimension"].as_f64().unwrap();
        let shares = design["shares"].as_object().unwrap();
        let mean: f64 = shares
            .iter()
            .map(|(q, w)| w.as_f64().unwrap() * design["sensitivities"][q].as_f64().unwrap())
            .sum();
        assert!((mean - p).abs() < 1e-7 * p, "{name}: {mean} {p}");
    }
    // A is the sum of the squared standard errors, and no other design's is smaller.
    let squares = |design: &Value| -> f64 {
        let errors = design["covariance"]["standard_errors"].as_object().unwrap();
        errors.values().map(|e| e.as_f64().unwrap().powi(2)).sum()
    };
    let own = designs[1]["covariance"]["value"].as_f64().unwrap();
    assert!((squares(&designs[1]) - own).abs() < 1e-9 * own);
    assert!(designs.iter().all(|design| squares(design) >= own * (1.0 - 1e-9)));
}

#[test]
fn the_default_is_the_papers_criterion_whatever_the_moments_hold() {
    let folder = folder();
    run(&folder, DESIGN).succeeds();
    let found = data(&folder);
    run(&folder, MOMENTS).succeeds();
    run(&folder, DESIGN).succeeds();
    assert_eq!(found, data(&folder));
    assert!(found.get("covariance").is_none() && found.get("available").is_none());
}

#[test]
fn what_is_available_bounds_shares_and_counts() {
    let folder = folder();
    put(
        &folder,
        "available.toml",
        "[seconds]\nspiral-fast = 20.0\n[segments]\ndecelerate = 1\naccelerate = 0\n",
    );
    let segments = "--segments 10 --segment-samples 100 --available";
    run(&folder, &format!("{DESIGN} {segments} available.toml")).succeeds();
    let toml = data(&folder);
    assert_eq!(toml["status"], "stationary", "{}", toml["statement"]);
    assert_eq!(toml["available"]["spiral-fast"], 0.16);
    let share = |name: &str| toml["shares"][name].as_f64().unwrap();
    assert!(share("spiral-fast") <= 0.16 && share("decelerate") <= 0.1 && share("accelerate") == 0.0);
    assert!((share("spiral-fast") - 0.16).abs() < 1e-9, "it would take more");
    let count = |name: &str| toml["counts"][name].as_u64().unwrap();
    // 20 s are one segment of 12.5 s.
    assert!(count("spiral-fast") <= 1 && count("decelerate") <= 1 && count("accelerate") == 0);
    assert_eq!(sum(&toml["counts"]), 10.0);
    assert_eq!(toml["counted"]["method"], "exhaustive");
    put(
        &folder,
        "available.json",
        r#"{"seconds": {"spiral-fast": 20.0}, "segments": {"decelerate": 1, "accelerate": 0}}"#,
    );
    run(&folder, &format!("{DESIGN} {segments} available.json")).succeeds();
    assert_eq!(data(&folder), toml);
}

#[test]
fn what_ingest_cut_is_what_is_available() {
    use study::documents::{IngestDocument, ManeuverCount};
    let folder = folder();
    let moments = json(&folder, "moments.json")["data"]["maneuvers"].clone();
    let names = || moments.as_array().unwrap().iter().map(|m| m["name"].as_str().unwrap());
    let segments = |name: &str| if name.starts_with("zig-zag") { 3 } else { 1 };
    let cut = |name: &str| ManeuverCount { name: name.to_owned(), segments: segments(name), samples: 100 };
    let document = IngestDocument {
        data: None,
        vessel: None,
        design: "measured".to_owned(),
        reference_point: None,
        sample_rate_hz: 8.0,
        runs: 11,
        samples: 1100,
        maneuvers: names().map(cut).collect(),
        recordings: Vec::new(),
    };
    let file = folder.path().join("ingest.json");
    files::commit(vec![files::stage_document(file, &Default::default(), &document).unwrap()]).unwrap();
    let table: String = names().map(|name| format!("{name} = {}\n", segments(name))).collect();
    put(&folder, "available.toml", &format!("[segments]\n{table}"));
    let designed = |available: &str| {
        let flags = "--segments 10 --segment-samples 100 --available";
        run(&folder, &format!("{DESIGN} {flags} {available}")).succeeds();
        data(&folder)
    };
    let found = designed("ingest.json");
    assert_eq!(found, designed("available.toml"));
    let within = |(name, count): (&String, &Value)| count.as_u64().unwrap() <= segments(name);
    assert!(found["counts"].as_object().unwrap().iter().all(within), "{}", found["counts"]);
}

#[test]
fn counts_are_better_than_shares_apportioned() {
    let folder = folder();
    for (segments, method) in [(5, "exhaustive"), (40, "exchange")] {
        run(&folder, &format!("{DESIGN} --segments {segments} --segment-samples 25 --criterion a"))
            .succeeds();
        let found = data(&folder);
        assert_eq!(found["counted"]["method"], method);
        assert_eq!(sum(&found["counts"]), f64::from(segments));
        let (efficiency, gap) =
            (found["counted"]["efficiency"].as_f64().unwrap(), found["counted"]["gap"].as_f64().unwrap());
        assert!(efficiency <= 1.0 && gap >= 1.0 - efficiency - 1e-9 && gap < 0.2, "{}", found["counted"]);
    }
}

#[test]
fn refusals_of_what_is_available() {
    let folder = folder();
    let line = format!("{DESIGN} --available available.toml");
    let try_with = |text: &str, flags: &str, code: i32, pieces: &[&str]| {
        put(&folder, "available.toml", text);
        refused(&folder, code, &format!("{line} {flags}"), pieces);
    };
    try_with(
        "[seconds]\nspiral-fats = 2.0\n",
        "--duration-s 9",
        3,
        &["available.toml", "spiral-fats", "`spiral-fast`"],
    );
    try_with("[seconds]\nspiral-fast = -1.0\n", "--duration-s 9", 3, &["spiral-fast", "-1", "0 s or more"]);
    try_with("[seconds]\nspiral-fast = 2.0\n", "", 2, &["--available", "--duration-s"]);
    try_with("[segments]\nspiral-fast = 2\n", "--duration-s 9", 2, &["--available", "--segments"]);
    try_with("[second]\nspiral-fast = 2.0\n", "--duration-s 9", 3, &["second", "seconds"]);
    let both = "[seconds]\nspiral-fast = 2.0\n[segments]\nspiral-fast = 2\n";
    try_with(both, "--segments 5 --segment-samples 200", 3, &["spiral-fast", "one limit"]);
    let names = json(&folder, "moments.json")["data"]["maneuvers"].clone();
    let scarce: String = names
        .as_array()
        .unwrap()
        .iter()
        .map(|m| format!("{} = 1.0\n", m["name"].as_str().unwrap()))
        .collect();
    try_with(&format!("[seconds]\n{scarce}"), "--duration-s 125", 4, &["available.toml", "8.8 %", "100 %"]);
    put(&folder, "available.json", "{\"seconds\": {\"spiral-fast\": \"much\"}}");
    refused(
        &folder,
        3,
        &format!("{DESIGN} --duration-s 9 --available available.json"),
        &["available.json", "line 1"],
    );
}

#[test]
fn refusals_of_criteria() {
    let folder = folder();
    let a = format!("{DESIGN} --criterion a");
    let relative = format!("{DESIGN} --criterion a-relative");
    refused(&folder, 3, &relative, &["moments.json", "`X_uu`", "found 0", "--relative-to value"]);
    run(&folder, MOMENTS).succeeds();
    refused(&folder, 3, &a, &["moments.json", "disturbances", "--campaign"]);
    let noise = "std_r_rad_s = 0.15811388300841897";
    edit(&folder, "campaign.toml", noise, "std_r_rad_s = 0.0");
    edit(&folder, "campaign.toml", "kind = \"white\"\nstd_m_s = 0.15811388300841897", "kind = \"none\"");
    for state in ["u", "v"] {
        let key = format!("std_{state}_m_s = ");
        edit(&folder, "campaign.toml", &format!("{key}0.15811388300841897"), &format!("{key}0.0"));
    }
    run(&folder, EXPECTED).succeeds();
    for name in ["d", "a"] {
        refused(
            &folder,
            4,
            &format!("{DESIGN} --criterion {name}"),
            &["moments.json", "parameter `X_u`", "singular"],
        );
    }
}

#[test]
fn least_squares_instruments_have_no_such_covariance() {
    let folder = folder();
    let line = format!("{EXPECTED} --estimator ls").replace("moments.json", "other.json");
    run(&folder, &line).refuses(3, &["campaign.toml", "measurement", "--estimator iv"]);
}
