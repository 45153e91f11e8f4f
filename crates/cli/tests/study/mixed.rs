//! Files of different studies: refused, or labelled if requested.

use std::fs;

use tempfile::TempDir;

use crate::support::*;

/// A study whose estimates were made with another campaign than the one next to them.
fn mixed() -> TempDir {
    let folder = with(&MADE);
    edit(&folder, "campaign.toml", "seed = 1", "seed = 2");
    folder
}

#[test]
fn estimates_of_another_campaign_are_not_scored() {
    let folder = mixed();
    fs::remove_file(folder.path().join("scores.parquet")).unwrap();
    let pieces = ["provenance", "another campaign than that of campaign.toml", "--allow=mixed"];
    refused(&folder, 3, VALIDATE, &pieces);
    assert!(!folder.path().join("scores.parquet").exists());
    run(&folder, &format!("{VALIDATE} --allow=mixed")).succeeds();
    let settings = json(&folder, "validation.json")["settings"].clone();
    assert_eq!(settings["mixed"], serde_json::json!(["campaign"]));
}

#[test]
fn what_was_made_of_a_mixture_stays_labelled() {
    let folder = with(&MADE);
    edit(&folder, "dictionary.toml", "name = \"zig-zag", "# another\nname = \"zig-zag");
    refused(&folder, 3, CAMPAIGN, &["another dictionary than that of", "dictionary.toml"]);
    run(&folder, &format!("{CAMPAIGN} --allow=mixed")).succeeds();
    run(&folder, ESTIMATE).succeeds();
    assert_eq!(json(&folder, "estimate.json")["settings"]["mixed"], serde_json::json!(["dictionary"]));
}

#[test]
fn a_page_of_two_studies_is_refused_or_says_so() {
    let folder = mixed();
    fs::remove_file(folder.path().join("report.html")).unwrap();
    refused(&folder, 3, REPORT, &["another campaign than that of"]);
    assert!(!folder.path().join("report.html").exists());
    run(&folder, &format!("{REPORT} --allow=mixed")).succeeds();
    let page = fs::read_to_string(folder.path().join("report.html")).unwrap();
    assert!(page.contains("Mixed: this page shows files of different studies"));
    let folder = with(&MADE);
    run(&folder, REPORT).succeeds();
    assert!(!fs::read_to_string(folder.path().join("report.html")).unwrap().contains("Mixed:"));
}

#[test]
fn a_design_beside_runs_of_another_design_is_refused_by_the_page() {
    let folder = with(&MADE);
    run(&folder, &format!("{DESIGN} --segments 20 --segment-samples 50")).succeeds();
    refused(&folder, 3, REPORT, &["another design than that of"]);
}

#[test]
fn verify_prints_what_was_made_of_what() {
    let folder = with(&MADE);
    let said = run(&folder, "verify . --study .").succeeds();
    let graph = "design.json: design/2, of moments (moments.json)";
    assert!(said.stdout.lines().any(|line| line == graph), "{said}");
    assert!(said.stdout.contains("whole and of one study"), "{said}");
}

#[test]
fn verify_finds_what_is_damaged_changed_or_of_another_study() {
    let folder = mixed();
    let said = run(&folder, "verify . --study .");
    assert_eq!(said.code, Some(3), "{said}");
    assert!(said.stdout.contains("fault: ./scores.parquet: provenance: found another campaign"), "{said}");
    let folder = with(&MADE);
    edit(&folder, "design.json", "\"status\": \"", "\"status\":  \"");
    let said = run(&folder, "verify .");
    assert_eq!(said.code, Some(3), "{said}");
    assert!(
        said.stdout.contains("design.json: damaged") && said.stdout.contains("design.json: seal"),
        "{said}"
    );
    let folder = tempfile::tempdir().unwrap();
    run(&folder, "verify .").refuses(3, &["no document and no table"]);
}
