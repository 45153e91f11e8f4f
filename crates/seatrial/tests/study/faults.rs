//! Stages that are killed, fail, or are pointed where no file belongs: what stands in the folder afterwards belongs together.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};

use artifact::{TableReader, read_document};
use study::documents::{EstimateDocument, ValidationDocument};
use tempfile::TempDir;

use crate::support::{ESTIMATE, SEATRIAL, VALIDATE, cases, edit, run, with};

/// Whether `line` comes to its end in `folder`, where `fault`, such as `kill:3`, awaits it.
fn ends(folder: &TempDir, line: &str, fault: &str) -> bool {
    let mut command = Command::new(SEATRIAL);
    command.args(line.split_whitespace()).current_dir(folder).env("SEATRIAL_FAULT", fault);
    command.stderr(Stdio::null()).stdout(Stdio::null()).status().unwrap().success()
}

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

fn put_back(folder: &TempDir, before: &BTreeMap<PathBuf, Vec<u8>>) {
    files(folder).keys().for_each(|path| fs::remove_file(path).unwrap());
    before.iter().for_each(|(path, bytes)| fs::write(path, bytes).unwrap());
}

/// Runs `line` with a fault of `kind` at every place that it comes to, each time over what an earlier run of it left.
/// After `read`, the folder holds what it held before or what the run without a fault leaves.
fn at_every_place(folder: &TempDir, line: &str, kind: &str, read: impl Fn(&TempDir)) {
    let before = files(folder);
    run(folder, line).succeeds();
    let after = files(folder);
    assert_ne!(before, after);
    let mut seen = [0, 0];
    for count in 1.. {
        put_back(folder, &before);
        let ended = ends(folder, line, &format!("{kind}:{count}"));
        // Whoever reads next completes what was begun.
        read(folder);
        let found: BTreeMap<_, _> =
            files(folder).into_iter().filter(|(path, _)| !is_unfinished(path)).collect();
        assert!(found == before || found == after, "{line}: {kind}:{count} leaves a mixture");
        seen[usize::from(found == after)] += 1;
        if ended {
            break;
        }
        run(folder, line).succeeds();
        assert_eq!(files(folder), after, "{line}: leftovers of {kind}:{count}");
    }
    assert!(seen[0] > 3 && seen[1] > 0, "{line}: {kind}: {seen:?}");
}

fn read_estimates(folder: &TempDir) {
    let path = |name: &str| folder.path().join(name);
    TableReader::open(path("estimates.parquet"), "estimates", 1).unwrap();
    read_document::<EstimateDocument>(path("estimate.json")).unwrap();
}

fn read_scores(folder: &TempDir) {
    let path = |name: &str| folder.path().join(name);
    TableReader::open(path("scores.parquet"), "scores", 1).unwrap();
    read_document::<ValidationDocument>(path("validation.json")).unwrap();
}

#[test]
fn law_a_fault_at_any_place_leaves_the_old_estimates_or_the_new() {
    let folder = with(&["campaign.parquet", "estimates.parquet", "estimate.json"]);
    let line = format!("{ESTIMATE} --estimator ls");
    for kind in ["kill", "error"] {
        run(&folder, ESTIMATE).succeeds();
        at_every_place(&folder, &line, kind, read_estimates);
    }
}

#[test]
fn law_a_fault_at_any_place_leaves_the_old_scores_or_the_new() {
    let folder = with(&["estimates.parquet", "validation.parquet", "scores.parquet", "validation.json"]);
    edit(&folder, "campaign.toml", "parameter_error_bound = 5", "parameter_error_bound = 6");
    at_every_place(&folder, &format!("{VALIDATE} --allow-mixed"), "kill", read_scores);
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
    for redirection in [">&-", "2>&-", ">/dev/full", "2>/dev/full", ">&- 2>&-"] {
        let line = format!("exec \"$0\" {ESTIMATE} {redirection}");
        let status = Command::new("sh").args(["-c", &line, SEATRIAL]).current_dir(&folder).status().unwrap();
        assert_eq!(status.code(), Some(0), "{redirection}");
    }
    let refused = format!("exec \"$0\" {} >&- 2>&-", ESTIMATE.replace("campaign.parquet", "none.parquet"));
    let status = Command::new("sh").args(["-c", &refused, SEATRIAL]).current_dir(&folder).status().unwrap();
    assert_eq!(status.code(), Some(1));
}

#[cfg(unix)]
#[test]
fn two_processes_write_one_set_one_after_the_other() {
    let folder = with(&["campaign.parquet"]);
    let start = |estimator: &str| start(&folder, &format!("{ESTIMATE} --estimator {estimator}"));
    for _ in 0..8 {
        let both = [start("ls"), start("iv")];
        both.into_iter().for_each(|mut child| assert!(child.wait().unwrap().success()));
        read_estimates(&folder);
    }
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

/// Whatever the moment, the set that a killed process leaves is whole, and the next run clears what it left besides.
#[cfg(unix)]
#[test]
fn law_processes_killed_at_any_moment_leave_the_old_set_or_the_new() {
    let folder = with(&["campaign.parquet", "estimates.parquet", "estimate.json"]);
    let started = std::time::Instant::now();
    run(&folder, ESTIMATE).succeeds();
    let whole = started.elapsed();
    let mut ended = 0;
    for i in 0..cases() / 40 {
        let line = format!("{ESTIMATE} --estimator {}", ["ls", "iv"][i as usize % 2]);
        let mut child = start(&folder, &line);
        // Spread over the whole run by the golden section.
        std::thread::sleep(whole.mul_f64((f64::from(i) * 0.618_034).fract()));
        let signal = ["KILL", "INT", "TERM"][i as usize % 3];
        Command::new("kill")
            .args(["-s", signal, &child.id().to_string()])
            .stderr(Stdio::null())
            .status()
            .unwrap();
        ended += u32::from(child.wait().unwrap().success());
        read_estimates(&folder);
    }
    run(&folder, ESTIMATE).succeeds();
    let left: Vec<PathBuf> = files(&folder).into_keys().filter(|path| is_unfinished(path)).collect();
    assert!(left.is_empty(), "{left:?}");
    println!("{} runs killed, {ended} of them after their end; no set mixed, no file left", cases() / 40);
}
