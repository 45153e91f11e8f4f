//! What a stage reads is its input, what it writes is its output, and nothing is read or written anywhere else.

use std::collections::{BTreeMap, BTreeSet};
use std::ffi::OsStr;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use serde_json::Value;
use tempfile::TempDir;

use crate::logs::{few_candidates, logged};
use crate::planned::small_with;
use crate::support::*;

/// A study on the cell of the bay with its updates, in a tide; the ship needs 6 m.
fn charted() -> TempDir {
    let tide = "departure = \"2026-06-01T08:00:00Z\"\ntide = { file = \"tide.csv\", until = \"2026-06-01T12:00:00Z\" }\nheadings = 4";
    let folder = small_with(&[
        ("file = \"land.geojson\"\nkind = \"land\"", "file = \"cells/ZZ5BAY01.000\""),
        ("margin_m = 20.0", "margin_m = 20.0\ntransit_depth_m = 6.0\ntrial_depth_m = 6.0"),
        ("headings = 4", tide),
    ]);
    put(&folder, "tide.csv", "time,level_m\n2026-06-01T06:00:00Z,1.0\n2026-06-01T14:00:00Z,1.5\n");
    fs::create_dir(folder.path().join("cells")).unwrap();
    for suffix in ["000", "001", "002"] {
        let name = format!("ZZ5BAY01.{suffix}");
        fs::copy(
            repository().join("fixtures/charts/enc").join(&name),
            folder.path().join("cells").join(name),
        )
        .unwrap();
    }
    edit(&folder, "campaign.toml", "realizations = 200", "realizations = 2");
    // Most of the time would go to the search for an order.
    edit(&folder, "campaign.toml", "duration_s = 1902.0", "duration_s = 450.0");
    put(
        &folder,
        "study.toml",
        "moments.estimator = \"iv\"\ndesign.for = \"iv\"\nestimate.estimator = \"iv\"\n",
    );
    folder
}

/// A study `mine` of the logs in the folder `logs`, whose next trial is designed of few maneuvers, and how it is run to its first
/// stage.
fn of_logs() -> TempDir {
    let folder = logged(2, "heading", "heading");
    run(&folder, "new mine --vessel model-ship --logs logs").succeeds();
    few_candidates(&folder);
    folder
}

const INGEST: &str = "run mine --out out --json --quiet --stage ingest";
const PLAN: &str = "run . --out out --json --quiet --stage plan";
const ALL: &str = "run . --out out --json --quiet";

/// The stages that `line` ran, or the exit code of its refusal.
fn ran(folder: &TempDir, line: &str) -> Result<Vec<String>, i32> {
    let ran = run(folder, line);
    if ran.code != Some(0) {
        let code = ran.code.unwrap_or(-1);
        assert!([1, 2, 3, 4].contains(&code) && ran.stderr.lines().count() == 1, "{ran}");
        return Err(code);
    }
    let said: Value = serde_json::from_str(&ran.stdout).unwrap();
    Ok(said["run"].as_array().unwrap().iter().map(|name| name.as_str().unwrap().to_owned()).collect())
}

/// What run.json says that `stage` had as `inputs` or `outputs`.
fn recorded(folder: &TempDir, stage: &str, kind: &str) -> BTreeSet<String> {
    let stages = json(folder, "out/run.json")["data"]["stages"].clone();
    stages[stage][kind].as_object().unwrap().keys().cloned().collect()
}

/// All files below `folder`, relative to `top`.
fn files(folder: &Path, top: &Path) -> BTreeSet<String> {
    let mut all = BTreeSet::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            all.extend(files(&path, top));
        } else {
            all.insert(path.strip_prefix(top).unwrap().display().to_string());
        }
    }
    all
}

/// Files below `folder` that the program opened for reading, by strace; `None` where there is none.
fn traced(folder: &TempDir, line: &str) -> Option<BTreeSet<PathBuf>> {
    if Command::new("strace").arg("-V").output().is_err() {
        eprintln!("skipped: strace is not installed");
        return None;
    }
    let (top, trace) = (folder.path().canonicalize().unwrap(), tempfile::NamedTempFile::new().unwrap());
    let mut command = Command::new("strace");
    command.args(["-f", "-qq", "-s", "4096", "-e", "trace=open,openat,openat2", "-o"]).arg(trace.path());
    let done = command.arg(SEATRIAL).args(line.split_whitespace()).current_dir(&top).output().unwrap();
    if String::from_utf8_lossy(&done.stderr).contains("ptrace") {
        eprintln!("skipped: strace may not trace here");
        return None;
    }
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    let text = fs::read_to_string(trace.path()).unwrap();
    let reads = text.lines().filter(|line| line.contains("O_RDONLY") && !line.contains("O_DIRECTORY"));
    let opened = reads.filter(|line| !line.contains(" = -1 ")).filter_map(|line| line.split('"').nth(1));
    let whole = opened.filter_map(|path| top.join(path).canonicalize().ok());
    Some(whole.filter(|path| path.starts_with(&top) && path.is_file()).collect())
}

/// Runs `line` and checks that what strace sees opened are inputs or outputs in run.json.
fn run_traced(folder: &TempDir, study: &str, line: &str) {
    let Some(opened) = traced(folder, line) else { return drop(ran(folder, line).unwrap()) };
    let top = folder.path().canonicalize().unwrap();
    let stages = json(folder, "out/run.json")["data"]["stages"].clone();
    let keys =
        |kind| stages.as_object().unwrap().keys().flat_map(|name| recorded(folder, name, kind)).collect();
    let [inputs, outputs]: [Vec<String>; 2] = ["inputs", "outputs"].map(keys);
    let path =
        |key: &String| top.join(key.replace("{study}", study).replace("{out}", "out")).canonicalize().ok();
    let known: BTreeSet<PathBuf> = inputs.iter().chain(&outputs).filter_map(path).collect();
    // Those that say which stages there are, and which have run, are read every time.
    let own = ["out/run.json", "study.toml"];
    let is_missed = |path: &&PathBuf| !known.contains(*path) && !own.iter().any(|name| path.ends_with(name));
    let missed: Vec<&PathBuf> = opened.iter().filter(is_missed).collect();
    assert!(missed.is_empty() && opened.len() > 3, "{missed:?} of {opened:?}");
}

#[test]
fn law_a_plan_is_made_again_or_refused_after_any_change_of_what_it_read() {
    let folder = charted();
    assert_eq!(ran(&folder, PLAN).unwrap(), ["dictionary", "moments", "design", "plan"]);
    assert_eq!(ran(&folder, PLAN).unwrap(), [""; 0]);
    let all = recorded(&folder, "plan", "inputs");
    let own: Vec<&str> = all.iter().filter_map(|key| key.strip_prefix("{study}/")).collect();
    for name in [
        "plan.toml",
        "vessel.toml",
        "tide.csv",
        "cells/ZZ5BAY01.000",
        "cells/ZZ5BAY01.001",
        "cells/ZZ5BAY01.002",
    ] {
        assert!(own.contains(&name), "{name} in {all:?}");
    }
    // Removed, damaged, a pipe in its place: it is never called up to date. What is refused is not noted.
    for name in own {
        let path = folder.path().join(name);
        let Ok(whole) = fs::read(&path) else {
            fs::write(&path, "{").unwrap();
            assert!(ran(&folder, PLAN).is_err(), "{name} appeared");
            fs::remove_file(path).unwrap();
            continue;
        };
        for change in ["damaged", "removed", "pipe"] {
            fs::remove_file(&path).unwrap();
            match change {
                "damaged" => fs::write(&path, &whole[..whole.len() / 2]).unwrap(),
                "pipe" => assert!(Command::new("mkfifo").arg(&path).status().unwrap().success()),
                _ => {}
            }
            let fault = run(&folder, "verify out --study .");
            assert!(fault.code == Some(3) && fault.stdout.contains(name), "{change} {name}: {fault}");
            let again = ran(&folder, PLAN);
            assert!(
                again.as_ref().is_ok_and(|ran| ran.contains(&"plan".to_owned())) || again.is_err(),
                "{change} {name}: {again:?}"
            );
            let _ = fs::remove_file(&path);
            fs::write(&path, &whole).unwrap();
            if again.is_ok() {
                assert!(ran(&folder, PLAN).unwrap().contains(&"plan".to_owned()), "{name} is back");
            }
            assert_eq!(ran(&folder, PLAN).unwrap(), [""; 0], "{name} is as it was");
        }
    }
    // What appears where the stage looks
    for name in ["cells/ZZ5BAY01.003", "cells/2/zz5bay01.003", "CATALOG.031", "cells/catalog.031"] {
        let path = folder.path().join(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(&path, "no update").unwrap();
        assert!(ran(&folder, PLAN).is_err(), "{name}");
        fs::remove_file(path).unwrap();
    }
    put(&folder, "cells/notes.txt", "no chart");
    assert_eq!(ran(&folder, PLAN).unwrap(), [""; 0], "nobody looks for notes");
    run(&folder, "verify out --study .").succeeds();
    // Without the record, the documents are compared.
    fs::remove_file(folder.path().join("out/run.json")).unwrap();
    run(&folder, "verify out --study .").succeeds();
    for name in ["cells/ZZ5BAY01.002", "tide.csv", "plan.toml"] {
        let path = folder.path().join(name);
        let whole = fs::read(&path).unwrap();
        match name {
            "cells/ZZ5BAY01.002" => fs::remove_file(&path).unwrap(),
            _ => fs::write(&path, [&whole[..], b"\n"].concat()).unwrap(),
        }
        let fault = run(&folder, "verify out --study .");
        let role =
            if name == "plan.toml" { "plan: found" } else { path.file_stem().unwrap().to_str().unwrap() };
        assert!(fault.code == Some(3) && fault.stdout.contains(role), "{name}: {fault}");
        fs::write(path, whole).unwrap();
    }
}

#[test]
fn law_every_stage_runs_again_after_a_change_of_any_file_that_it_read() {
    for (folder, study, line) in
        [(charted(), ".", ALL), (of_logs(), "mine", "run mine --out out --json --quiet")]
    {
        let all = ran(&folder, line).unwrap();
        let mut readers: BTreeMap<String, BTreeSet<&str>> = BTreeMap::new();
        for stage in &all {
            for key in recorded(&folder, stage, "inputs") {
                readers.entry(key).or_default().insert(stage);
            }
        }
        // Results that other stages read are made again themselves.
        let path = |key: &str| folder.path().join(key.replace("{study}", study));
        // One log stands for all of them.
        let (own, logs): (Vec<_>, Vec<_>) = readers
            .into_iter()
            .filter(|(key, _)| !key.starts_with("{out}") && path(key).is_file())
            .partition(|(key, _)| key.starts_with("{study}"));
        let written: Vec<_> = own.into_iter().chain(logs.into_iter().take(1)).collect();
        assert!(written.len() >= 3, "{written:?}");
        let mut expected: BTreeSet<&str> = BTreeSet::new();
        for (key, stages) in written {
            let whole = fs::read(path(&key)).unwrap();
            let is_text = key.ends_with(".toml") || key.ends_with(".csv");
            fs::write(path(&key), [&whole[..], if is_text { b"\n" } else { b"\0" }].concat()).unwrap();
            let name = key.rsplit('/').next().unwrap();
            let fault = run(&folder, &format!("verify out --study {study}"));
            assert!(fault.code == Some(3) && fault.stdout.contains(name), "{key}: {fault}");
            // Estimates of logs take long: there all changes are run at once.
            if study == "mine" {
                match is_text {
                    true => expected.extend(stages),
                    false => fs::write(path(&key), whole).unwrap(),
                }
                continue;
            }
            let again = ran(&folder, line);
            let is_seen = |ran: &Vec<String>| stages.iter().all(|stage| ran.iter().any(|own| own == stage));
            assert!(again.as_ref().map_or(!is_text, is_seen), "{key}: {stages:?}, {again:?}");
            if again.is_err() {
                fs::write(path(&key), whole).unwrap();
            }
        }
        if study == "mine" {
            let again = ran(&folder, line).unwrap();
            assert!(expected.len() > 3 && expected.iter().all(|stage| again.iter().any(|own| own == stage)));
        }
    }
}

#[test]
fn law_every_file_of_the_results_is_an_output_that_is_made_again() {
    let folder = charted();
    run_traced(&folder, ".", ALL);
    assert_eq!(ran(&folder, ALL).unwrap(), [""; 0]);
    let stages = json(&folder, "out/run.json")["data"]["stages"].clone();
    let outputs = stages.as_object().unwrap().keys().flat_map(|stage| recorded(&folder, stage, "outputs"));
    let outputs: BTreeSet<String> = outputs.map(|key| key.replace("{out}/", "")).collect();
    let mut found = files(&folder.path().join("out"), &folder.path().join("out"));
    assert!(found.remove("run.json"));
    assert_eq!(outputs, found);
    let changed =
        ["out/route.rtz", "out/route.gpx", "out/track.geojson", "out/map.svg", "out/figures/map.svg"];
    let changed = changed.map(|name| (name, fs::read(folder.path().join(name)).ok()));
    for (name, _) in changed.iter().filter(|(_, whole)| whole.is_some()) {
        match *name {
            "out/route.gpx" => fs::remove_file(folder.path().join(name)).unwrap(),
            _ => put(&folder, name, "another"),
        }
    }
    let again = ran(&folder, ALL).unwrap();
    assert_eq!(
        again.iter().map(String::as_str).filter(|name| ["plan", "report"].contains(name)).count(),
        2,
        "{again:?}"
    );
    for (name, whole) in changed {
        assert!(fs::read(folder.path().join(name)).ok() == whole, "{name} is not as it was");
    }
}

#[test]
fn law_logs_that_appear_change_or_go_are_read_again() {
    let folder = of_logs();
    run_traced(&folder, "mine", INGEST);
    assert_eq!(ran(&folder, INGEST).unwrap(), [""; 0]);
    let mut all = files(&folder.path().join("logs"), folder.path());
    let first = all.pop_first().unwrap();
    let log = fs::read_to_string(folder.path().join(&first)).unwrap();
    fs::remove_file(folder.path().join(&first)).unwrap();
    let fault = run(&folder, "verify out --study mine");
    assert!(fault.code == Some(3) && fault.stdout.contains(&first), "{fault}");
    assert_eq!(ran(&folder, INGEST).unwrap(), ["ingest"], "gone");
    put(&folder, &first, log.trim_end().rsplit_once('\n').unwrap().0);
    assert_eq!(ran(&folder, INGEST).unwrap(), ["ingest"], "appeared");
    put(&folder, &first, &log);
    assert_eq!(ran(&folder, INGEST).unwrap(), ["ingest"], "changed");
    put(&folder, "logs/notes.txt", "no log");
    assert_eq!(ran(&folder, INGEST).unwrap(), [""; 0]);
    // Other logs of the same names, and results in another place
    fs::create_dir(folder.path().join("other")).unwrap();
    for name in files(&folder.path().join("logs"), &folder.path().join("logs")) {
        fs::copy(folder.path().join("logs").join(&name), folder.path().join("other").join(&name)).unwrap();
    }
    assert_eq!(ran(&folder, &format!("{INGEST} --logs other")).unwrap(), ["ingest"]);
    put(&folder, &first.replace("logs/", "other/"), "t");
    assert!(ran(&folder, &format!("{INGEST} --logs other")).is_err());
}

#[test]
fn placeholders_stand_only_in_what_the_program_wrote() {
    let folder = written(2);
    for name in WRITTEN {
        let own = folder.path().join("{out}");
        fs::create_dir_all(&own).unwrap();
        fs::copy(folder.path().join(name), own.join(name)).unwrap();
    }
    let line = "run {out} --out {study} --quiet --stage design";
    run(&folder, line).succeeds();
    assert!(folder.path().join("{study}/design.json").is_file());
    assert!(run(&folder, line).succeeds().stdout.contains("0 of 3 stages run"));
    // Of a stranger's study: links and a setting that would lead out of the results if they were put together
    let folder = charted();
    fs::create_dir_all(folder.path().join("victim/p")).unwrap();
    put(&folder, "victim/p/plan.json", "mine");
    fs::rename(folder.path().join("plan.toml"), folder.path().join("plan-{logs}.toml")).unwrap();
    put(&folder, "study.toml", "logs = \"/../../../../../../victim/p\"\n");
    fs::create_dir_all(folder.path().join("out/a/b/c/d/e")).unwrap();
    std::os::unix::fs::symlink("a/b/c/d/e", folder.path().join("out/plan-")).unwrap();
    run(&folder, "run . --out out --quiet --stage plan-{logs}").succeeds();
    assert!(folder.path().join("out/plan-{logs}/plan.json").is_file());
    assert_eq!(bytes(&folder, "victim/p/plan.json"), b"mine");
}

#[test]
fn nothing_is_written_outside_the_folder_of_the_results() {
    let folder = written(2);
    fs::create_dir(folder.path().join("victim")).unwrap();
    put(&folder, "victim/estimates.parquet", "mine");
    // A link within the results, one in place of a file, a key of study.toml
    fs::create_dir(folder.path().join("out")).unwrap();
    let link = |to: &str, name: &str| std::os::unix::fs::symlink(to, folder.path().join(name)).unwrap();
    link("../victim", "out/figures");
    run(&folder, "run . --out out --quiet")
        .refuses(3, &["figures", "victim", "expected one below", "remove the link"]);
    fs::remove_file(folder.path().join("out/figures")).unwrap();
    run(&folder, "run . --out out --quiet").succeeds();
    link("../victim/estimates.parquet", "out/other");
    fs::rename(folder.path().join("out/other"), folder.path().join("out/design.json")).unwrap();
    run(&folder, "run . --out out --quiet").refuses(3, &["design.json", "a link to"]);
    fs::remove_file(folder.path().join("out/design.json")).unwrap();
    // Results that are a link themselves are where it leads.
    fs::rename(folder.path().join("out"), folder.path().join("elsewhere")).unwrap();
    link("elsewhere", "out");
    run(&folder, "run . --out out --quiet").succeeds();
    assert_eq!(
        files(&folder.path().join("victim"), folder.path()),
        ["victim/estimates.parquet".to_owned()].into()
    );
    assert_eq!(bytes(&folder, "victim/estimates.parquet"), b"mine");
}

#[test]
fn what_is_no_file_or_too_long_is_refused_by_name_and_without_waiting() {
    let folder = written(2);
    assert!(Command::new("mkfifo").arg(folder.path().join("pipe.toml")).status().unwrap().success());
    for (device, piece) in
        [("/dev/zero", "a device"), ("/dev/stdin", "an ordinary file"), ("pipe.toml", "a pipe")]
    {
        put(&folder, "study.toml", &format!("dictionary = \"{device}\"\n"));
        run(&folder, "run . --out out --quiet --stage design").refuses(3, &[device, piece]);
    }
    fs::remove_file(folder.path().join("study.toml")).unwrap();
    for name in ["dictionary.toml", "vessel.toml"] {
        let whole = bytes(&folder, name);
        fs::File::options().write(true).open(folder.path().join(name)).unwrap().set_len(2 << 30).unwrap();
        run(&folder, "run . --out out --quiet --stage design")
            .refuses(3, &[name, "2147483648 bytes", "shorten"]);
        fs::write(folder.path().join(name), whole).unwrap();
    }
    fs::File::create(folder.path().join("study.toml")).unwrap().set_len(2 << 30).unwrap();
    run(&folder, "run . --out out --quiet --stage design").refuses(3, &["study.toml", "2147483648 bytes"]);
    // A text that names a path is no input.
    put(&folder, "study.toml", "[moments]\nestimator = \"iv\"\n[design]\nfor = \"iv\"\n");
    edit(&folder, "campaign.toml", "seed = 1", "name = \"/proc/self\"\nseed = 1");
    run(&folder, "run . --out out --quiet --stage design").succeeds();
}

#[test]
fn folders_that_are_not_utf_8_are_taken_as_they_are() {
    use std::os::unix::ffi::OsStrExt;
    let folder = written(2);
    let [study, out] = [b"s\xfftudy", b"o\xffut--"].map(|name| OsStr::from_bytes(name));
    fs::create_dir(folder.path().join(study)).unwrap();
    for name in WRITTEN {
        fs::rename(folder.path().join(name), folder.path().join(study).join(name)).unwrap();
    }
    let run = || -> Output {
        let mut command = Command::new(SEATRIAL);
        command
            .arg("run")
            .arg(study)
            .arg("--out")
            .arg(out)
            .arg("--quiet")
            .current_dir(&folder)
            .output()
            .unwrap()
    };
    let done = run();
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    assert!(folder.path().join(out).join("report.html").is_file());
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 2, "no other folder");
    assert!(String::from_utf8_lossy(&run().stdout).contains("0 of 8 stages run"));
}
