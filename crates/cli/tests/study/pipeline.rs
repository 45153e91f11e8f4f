//! The whole pipeline on a small study: files, messages, names and digests.

use std::collections::BTreeMap;

use files::{Digest, Provenance, TableReader};
use serde_json::Value;
use study::documents::{DesignDocument, EstimateDocument, MomentsDocument, ValidationDocument};

use crate::support::*;

#[test]
fn the_pipeline_writes_its_files_and_one_line_per_stage() {
    let folder = written(4);
    for stage in STAGES {
        let before = listing(folder.path());
        let ran = run(&folder, stage).succeeds();
        assert_eq!(ran.stdout.lines().count(), 1, "{ran}");
        let out = stage.rsplit_once(' ').unwrap().1;
        assert!(ran.stdout.starts_with(&format!("{out}: ")), "{ran}");
        assert!(!before.contains_key(&folder.path().join(out)) && folder.path().join(out).is_file(), "{ran}");
    }
    let names = listing(folder.path());
    for name in MADE {
        assert!(names.contains_key(&folder.path().join(name)), "{name} is missing");
    }
    let strange = names.keys().find(|name| name.to_string_lossy().contains("unfinished"));
    assert_eq!(strange, None, "a temporary file is left");
}

#[test]
fn with_json_every_stage_prints_one_object() {
    let folder = written(4);
    for stage in STAGES {
        let ran = run(&folder, &format!("{stage} --json --quiet")).succeeds();
        let said: Value = serde_json::from_str(&ran.stdout).unwrap_or_else(|e| panic!("{e}{ran}"));
        assert_eq!(ran.stdout.lines().count(), 1, "{ran}");
        assert_eq!(said["out"], stage.rsplit_once(' ').unwrap().1, "{ran}");
        assert_eq!(ran.stderr, "", "{ran}");
    }
}

#[test]
fn quiet_stages_print_nothing_on_stderr() {
    let folder = written(4);
    for stage in STAGES {
        let ran = run(&folder, &format!("{stage} --quiet")).succeeds();
        assert_eq!(ran.stderr, "", "{ran}");
    }
}

#[test]
fn a_folder_as_output_gets_the_usual_names() {
    let folder = with(&MADE);
    std::fs::create_dir(folder.path().join("out")).unwrap();
    for stage in STAGES {
        let (line, name) = stage.rsplit_once(' ').unwrap();
        run(&folder, &format!("{line} out/")).succeeds();
        assert!(folder.path().join("out").join(name).is_file(), "{stage}");
    }
    for name in MADE.iter().filter(|name| **name != "report.html") {
        assert!(bytes(&folder, name) == bytes(&folder, &format!("out/{name}")), "{name} has other bytes");
    }
}

/// Provenance of a file as its own reader sees it.
fn provenance(folder: &tempfile::TempDir, name: &str) -> Provenance {
    let table = |id| TableReader::open(folder.path().join(name), id, 1).unwrap().provenance().clone();
    match name {
        "moments.json" => document::<MomentsDocument>(folder, name).provenance,
        "design.json" => document::<DesignDocument>(folder, name).provenance,
        "estimate.json" => document::<EstimateDocument>(folder, name).provenance,
        "validation.json" => document::<ValidationDocument>(folder, name).provenance,
        "estimates.parquet" => table("estimates"),
        "scores.parquet" => table("scores"),
        _ => table("trajectories"),
    }
}

#[test]
fn every_file_tells_the_digests_of_what_it_was_made_from() {
    let folder = with(&MADE);
    let read: BTreeMap<&str, &[(&str, &str)]> = BTreeMap::from([
        ("dictionary.parquet", &[("dictionary", "dictionary.toml"), ("vessel", "vessel.toml")][..]),
        ("moments.json", &[("trajectories", "dictionary.parquet"), ("vessel", "vessel.toml")]),
        ("design.json", &[("moments", "moments.json")]),
        (
            "campaign.parquet",
            &[
                ("campaign", "campaign.toml"),
                ("design", "design.json"),
                ("dictionary", "dictionary.toml"),
                ("vessel", "vessel.toml"),
            ],
        ),
        ("validation.parquet", &[("campaign", "campaign.toml"), ("vessel", "vessel.toml")]),
        ("estimates.parquet", &[("trajectories", "campaign.parquet"), ("vessel", "vessel.toml")]),
        ("estimate.json", &[("trajectories", "campaign.parquet"), ("vessel", "vessel.toml")]),
        ("scores.parquet", &SCORED),
        ("validation.json", &SCORED),
    ]);
    for (name, inputs) in read {
        let expected: BTreeMap<String, Digest> = inputs
            .iter()
            .map(|(role, file)| ((*role).to_owned(), Digest::of_bytes(&bytes(&folder, file))))
            .collect();
        let found = provenance(&folder, name);
        assert_eq!(found.inputs, expected, "{name}");
        assert!(found.producer.ends_with(env!("CARGO_PKG_VERSION")), "{name}: {}", found.producer);
        assert_eq!(found.shard, None, "{name}");
    }
}

const SCORED: [(&str, &str); 4] = [
    ("campaign", "campaign.toml"),
    ("estimates", "estimates.parquet"),
    ("validation", "validation.parquet"),
    ("vessel", "vessel.toml"),
];

#[test]
fn inputs_from_a_file_are_in_the_provenance() {
    let folder = with(&[]);
    put(
        &folder,
        "dictionary.toml",
        "[[maneuver]]\nname = \"recorded\"\nkind = \"inputs\"\nfile = \"log.csv\"\n",
    );
    put(&folder, "log.csv", "tau1,tau2,tau3\n1,2,3\n4,5,6\n");
    run(&folder, DICTIONARY).succeeds();
    let inputs = provenance(&folder, "dictionary.parquet").inputs;
    assert_eq!(inputs["inputs:log.csv"], Digest::of_bytes(&bytes(&folder, "log.csv")));
}

#[test]
fn no_file_tells_a_folder_or_a_thread_count() {
    let folder = with(&MADE);
    let path = folder.path().to_string_lossy().into_owned();
    for name in MADE {
        let bytes = bytes(&folder, name);
        let text = String::from_utf8_lossy(&bytes);
        assert!(!text.contains(&path) && !text.contains("threads"), "{name}");
    }
}

#[test]
fn a_report_takes_maneuvers_from_a_dictionary_elsewhere() {
    let folder = with(&MADE);
    let report =
        |out: &str| format!("report --study . --dictionary other/shared.toml --results . --out {out}");
    let said = run(&folder, &report("none.html"));
    assert_eq!(said.code, Some(1), "{said}");
    assert!(said.stderr.contains("other/shared.toml") && !folder.path().join("none.html").exists(), "{said}");
    std::fs::create_dir(folder.path().join("other")).unwrap();
    std::fs::rename(folder.path().join("dictionary.toml"), folder.path().join("other/shared.toml")).unwrap();
    run(&folder, &report("told.html")).succeeds();
    assert!(bytes(&folder, "told.html") == study().bytes("report.html"), "the pages differ");
    let without = "report --study . --results . --out without.html";
    run(&folder, without).succeeds();
    assert!(bytes(&folder, "without.html") != study().bytes("report.html"), "the descriptions are not shown");
}
