//! Stages that are killed, fail, or write to invalid paths: the files in the folder belong together afterwards.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};

use tempfile::TempDir;

use crate::support::{ESTIMATE, SEATRIAL, VALIDATE, edit, run, with};

/// The files of `folder`.
fn files(folder: &TempDir) -> BTreeMap<PathBuf, Vec<u8>> {
    let entries = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    entries.filter(|path| path.is_file()).map(|path| (path.clone(), fs::read(&path).unwrap())).collect()
}

/// Starts `line` in `folder`, silently.
fn start(folder: &TempDir, line: &str) -> Child {
    let mut command = Command::new(SEATRIAL);
    command.args(line.split_whitespace()).current_dir(folder).stderr(Stdio::null()).stdout(Stdio::null());
    command.spawn().unwrap()
}

fn is_unfinished(path: &Path) -> bool {
    path.file_name().unwrap().to_string_lossy().starts_with(".unfinished")
}

#[test]
fn a_table_and_a_document_of_two_runs_are_refused_by_both_their_readers() {
    let folder = with(&["campaign.parquet", "validation.parquet", "estimates.parquet", "estimate.json"]);
    let document = fs::read(folder.path().join("estimate.json")).unwrap();
    run(&folder, &format!("{ESTIMATE} --estimator ls")).succeeds();
    fs::write(folder.path().join("estimate.json"), document).unwrap();
    let told = ["estimates.parquet: digest: found another file than the one written with", "estimate.json"];
    run(&folder, VALIDATE).refuses(3, &told);
    run(&folder, "report --study . --results . --out report.html").refuses(3, &told);
}

#[test]
fn documents_are_named_after_their_tables() {
    let folder = with(&["campaign.parquet"]);
    run(&folder, &ESTIMATE.replace("estimates.parquet", "estimates-2.parquet")).succeeds();
    run(&folder, &ESTIMATE.replace("estimates.parquet", "tank.parquet")).succeeds();
    let there = |name: &str| folder.path().join(name).is_file();
    assert!(there("estimate-2.json") && there("tank-estimate.json") && !there("estimate.json"));
}

#[cfg(unix)]
#[test]
fn what_is_no_file_is_never_replaced() {
    let folder = with(&["campaign.parquet"]);
    let link = folder.path().join("link.parquet");
    std::os::unix::fs::symlink("/dev/stdout", &link).unwrap();
    let out = |name: &str| ESTIMATE.replace("estimates.parquet", name);
    run(&folder, &out("link.parquet")).refuses(3, &["link.parquet: output: found a link to /dev/stdout"]);
    run(&folder, &out("/dev/null")).refuses(3, &["/dev/null: output: found a device or pipe"]);
    assert!(link.is_symlink());
}

#[cfg(unix)]
#[test]
fn a_closed_or_full_output_is_no_panic() {
    let folder = with(&["campaign.parquet"]);
    let ended = |line: &str| {
        let line = format!("exec \"$0\" {line}");
        Command::new("sh").args(["-c", &line, SEATRIAL]).current_dir(&folder).status().unwrap().code()
    };
    for redirection in [">&-", "2>&-", "2>/dev/full", ">&- 2>&-"] {
        assert_eq!(ended(&format!("{ESTIMATE} {redirection}")), Some(0), "{redirection}");
    }
    // What is lost on a full disk is no success, of nothing that prints.
    let lines = [
        ESTIMATE,
        &format!("{ESTIMATE} --json"),
        "--help",
        "--version",
        "verify .",
        "completions bash",
        "completions man man",
    ];
    for line in lines {
        assert_eq!(ended(&format!("{line} >/dev/full")), Some(1), "{line}");
    }
    let refused = format!("exec \"$0\" {} >&- 2>&-", ESTIMATE.replace("campaign.parquet", "none.parquet"));
    let status = Command::new("sh").args(["-c", &refused, SEATRIAL]).current_dir(&folder).status().unwrap();
    assert_eq!(status.code(), Some(1));
}

#[test]
fn a_report_of_a_study_that_does_not_exist_is_refused() {
    let folder = with(&["design.json"]);
    let line = "report --study nowhere --results . --out report.html";
    run(&folder, line).refuses(3, &["nowhere: study: found no such folder", "--study"]);
    assert!(!folder.path().join("report.html").exists());
    edit(&folder, "campaign.toml", "duration_s = ", "duration_s = -");
    run(&folder, "report --study . --results . --out report.html")
        .refuses(3, &["campaign.toml: `duration_s`"]);
}

#[cfg(unix)]
#[test]
fn a_process_that_is_asked_to_end_leaves_nothing_unfinished() {
    let folder = with(&["campaign.parquet"]);
    let before = files(&folder);
    for (signal, code) in [("INT", 130), ("TERM", 143), ("HUP", 129)] {
        // Long enough that the signal comes while it runs.
        let line = format!("{ESTIMATE} --estimator prediction-error --campaign campaign.toml --threads 1");
        let mut child = start(&folder, &line);
        while !files(&folder).keys().any(|path| is_unfinished(path)) && child.try_wait().unwrap().is_none() {
            std::thread::sleep(std::time::Duration::from_millis(1));
        }
        let kill = Command::new("kill").args(["-s", signal, &child.id().to_string()]).status().unwrap();
        let ended = child.wait().unwrap();
        assert!(kill.success() && ended.code() == Some(code), "{signal}: {ended}");
        assert!(files(&folder) == before, "{signal} leaves something");
    }
}
