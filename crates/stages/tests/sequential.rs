//! Trials in rounds, through the binary.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use artifact::read_document;
use stages::documents::SequentialDocument;

fn repository(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").join(path)
}

const CONFIG: &str =
    "realizations = 40\nduration_s = 120.0\nrounds = 3\nnominal_spread = 0.4\naccuracy = 2.5\n";

/// Exit code, stdout, stderr.
fn run(folder: &Path, config: &str, more: &[&str]) -> (Option<i32>, String, String) {
    fs::write(folder.join("sequential.toml"), config).unwrap();
    let ran = Command::new(env!("CARGO_BIN_EXE_sequential"))
        .current_dir(folder)
        .arg("--vessel")
        .arg(repository("pipelines/paper/vessel.toml"))
        .arg("--dictionary")
        .arg(repository("pipelines/paper/dictionary.toml"))
        .arg("--campaign")
        .arg(repository("pipelines/paper/campaign.toml"))
        .args(["--config", "sequential.toml", "--out", "sequential.parquet", "--quiet"])
        .args(more)
        .output()
        .unwrap();
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    (ran.status.code(), text(&ran.stdout), text(&ran.stderr))
}

#[test]
fn designs_made_in_rounds_end_better_than_one_from_a_crude_model() {
    let folder = tempfile::tempdir().unwrap();
    let (code, said, complaint) = run(folder.path(), &CONFIG.replace("40", "120"), &[]);
    assert_eq!(code, Some(0), "{complaint}");
    assert!(said.contains("in rounds"), "{said}");
    let document = read_document::<SequentialDocument>(&folder.path().join("sequential.json")).unwrap().data;
    let end = |arm: usize| document.arms[arm].points[2].median.unwrap();
    let names: Vec<&str> = document.arms.iter().map(|arm| arm.name.as_str()).collect();
    assert_eq!(names, ["sequential", "one-shot", "informed", "random"]);
    assert!(end(0) < end(1) && end(2) < end(3), "{:?}", [0, 1, 2, 3].map(end));
    for arm in &document.arms {
        let medians: Vec<f64> = arm.points.iter().map(|p| p.median.unwrap_or(f64::INFINITY)).collect();
        assert!(medians[2] < medians[0], "more time, less error: {} {medians:?}", arm.name);
    }
}

#[test]
fn law_a_first_model_that_is_right_designs_as_the_truth_does() {
    let folder = tempfile::tempdir().unwrap();
    let vessel = fs::read_to_string(repository("pipelines/paper/vessel.toml")).unwrap();
    assert!(vessel.contains("nominal"), "{vessel}");
    let config =
        CONFIG.replace("nominal_spread = 0.4", "nominal_spread = 0.0").replace("rounds = 3", "rounds = 1");
    let (code, _, complaint) = run(folder.path(), &config, &[]);
    assert_eq!(code, Some(0), "{complaint}");
    let document = read_document::<SequentialDocument>(&folder.path().join("sequential.json")).unwrap().data;
    assert!(document.arms.iter().all(|arm| arm.points.len() == 1 && arm.points[0].time_s == 120.0));
    assert!(document.arms[..3].iter().all(|arm| arm.points[0].undesigned == 0));
}

#[test]
fn the_same_bytes_for_any_number_of_threads() {
    let bytes = |threads: &str| {
        let folder = tempfile::tempdir().unwrap();
        let (code, _, complaint) = run(folder.path(), CONFIG, &["--threads", threads]);
        assert_eq!(code, Some(0), "{complaint}");
        ["sequential.parquet", "sequential.json"].map(|name| fs::read(folder.path().join(name)).unwrap())
    };
    assert!(bytes("1") == bytes("2"));
}

#[test]
fn configurations_without_meaning_are_refused() {
    for (change, by, pieces) in [
        ("rounds = 3", "rounds = 0", vec!["`rounds`", "found 0", "more than zero"]),
        ("rounds = 3", "rounds = 5000", vec!["`rounds`", "5000 rounds of 960 samples"]),
        ("rounds = 3", "rouns = 3", vec!["`rouns`", "did you mean `rounds`?"]),
        ("accuracy = 2.5", "accuracy = nan", vec!["`accuracy`", "NaN"]),
        ("nominal_spread = 0.4", "nominal_spread = -1.0", vec!["`nominal_spread`", "0 to 2"]),
        ("accuracy = 2.5", "accuracy = 2.5\nestimator = \"refined\"", vec!["`refined`", "refined-iv"]),
    ] {
        let folder = tempfile::tempdir().unwrap();
        let (code, _, complaint) = run(folder.path(), &CONFIG.replace(change, by), &[]);
        assert_eq!((code, complaint.lines().count()), (Some(3), 1), "{complaint}");
        for piece in pieces.iter().chain(&["sequential.toml"]) {
            assert!(complaint.contains(piece), "`{piece}` is missing: {complaint}");
        }
        assert!(!folder.path().join("sequential.parquet").exists());
    }
}
