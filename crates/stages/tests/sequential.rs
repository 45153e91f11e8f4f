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
    with_campaign(folder, &repository("pipelines/paper/campaign.toml"), config, more)
}

fn with_campaign(
    folder: &Path,
    campaign: &Path,
    config: &str,
    more: &[&str],
) -> (Option<i32>, String, String) {
    fs::write(folder.join("sequential.toml"), config).unwrap();
    let ran = Command::new(env!("CARGO_BIN_EXE_sequential"))
        .current_dir(folder)
        .arg("--vessel")
        .arg(repository("pipelines/paper/vessel.toml"))
        .arg("--dictionary")
        .arg(repository("pipelines/paper/dictionary.toml"))
        .arg("--campaign")
        .arg(campaign)
        .args(["--config", "sequential.toml", "--out", "sequential.parquet", "--quiet"])
        .args(more)
        .output()
        .unwrap();
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    (ran.status.code(), text(&ran.stdout), text(&ran.stderr))
}

fn document(folder: &Path) -> SequentialDocument {
    read_document::<SequentialDocument>(&folder.join("sequential.json")).unwrap().data
}

#[test]
fn law_more_time_and_a_better_design_leave_less_error() {
    let folder = tempfile::tempdir().unwrap();
    let (code, said, complaint) = run(folder.path(), CONFIG, &[]);
    assert_eq!(code, Some(0), "{complaint}");
    assert!(said.contains("designed in rounds"), "{said}");
    let document = document(folder.path());
    let names: Vec<&str> = document.arms.iter().map(|arm| arm.name.as_str()).collect();
    assert_eq!(names, ["sequential", "one-shot", "informed", "random"]);
    let medians: Vec<Vec<f64>> = document
        .arms
        .iter()
        .map(|arm| arm.points.iter().map(|point| point.median.unwrap_or(f64::INFINITY)).collect())
        .collect();
    assert!(medians.iter().all(|own| own[2] < own[0]), "{medians:?}");
    assert!(medians[..3].iter().all(|own| own[2] < medians[3][2]), "designs beat chance: {medians:?}");
    let stopping = document.stopping;
    assert!(stopping.reached > 0 && stopping.mean_time_s.unwrap() <= 120.0, "{stopping:?}");
}

#[test]
fn law_a_first_model_without_spread_is_the_same_in_every_realization() {
    let folder = tempfile::tempdir().unwrap();
    let config =
        CONFIG.replace("nominal_spread = 0.4", "nominal_spread = 0.0").replace("rounds = 3", "rounds = 1");
    let (code, _, complaint) = run(folder.path(), &config, &[]);
    assert_eq!(code, Some(0), "{complaint}");
    let document = document(folder.path());
    assert!(document.arms.iter().all(|arm| arm.points.len() == 1 && arm.points[0].time_s == 120.0));
    assert!(document.arms.iter().all(|arm| arm.points[0].undesigned == 0));
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
        ("accuracy = 2.0", "accuracy = nan", vec!["`accuracy`", "NaN"]),
        ("nominal_spread = 0.4", "nominal_spread = -1.0", vec!["`nominal_spread`", "0 to 2"]),
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

#[test]
fn disturbances_that_the_prediction_is_not_for_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let campaign = fs::read_to_string(repository("pipelines/paper/campaign.toml")).unwrap();
    let lasting = campaign.replace("kind = \"white\"", "kind = \"constant\"");
    assert_ne!(campaign, lasting);
    fs::write(folder.path().join("campaign.toml"), lasting).unwrap();
    let (code, _, complaint) = run(folder.path(), CONFIG, &["--campaign", "campaign.toml"]);
    assert_eq!((code, complaint.lines().count()), (Some(2), 1), "named twice: {complaint}");
    let (code, _, complaint) = with_campaign(folder.path(), Path::new("campaign.toml"), CONFIG, &[]);
    assert_eq!((code, complaint.lines().count()), (Some(3), 1), "{complaint}");
    assert!(complaint.contains("a lasting current"), "{complaint}");
}
