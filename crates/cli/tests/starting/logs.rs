//! Studies of logs: what is guessed, what is corrected, and what comes of them.

use std::fs;

use tempfile::TempDir;

use crate::support::*;

/// A folder with `logs` of the model ship's simulated trial as if they were measured, with `from` in their headers replaced by
/// `to`.
fn logged(from: &str, to: &str) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    let study = repository().join("pipelines/model-ship");
    for name in ["vessel.toml", "dictionary.toml", "logs.toml"] {
        fs::copy(study.join(name), folder.path().join(name)).unwrap();
    }
    fs::create_dir(folder.path().join("logs")).unwrap();
    run(&folder, "simulate logs --vessel vessel.toml --dictionary dictionary.toml --logs logs.toml --out logs/simulated.json")
        .succeeds();
    // Without their seal they are any logs.
    fs::remove_file(folder.path().join("logs/simulated.json")).unwrap();
    for entry in fs::read_dir(folder.path().join("logs")).unwrap() {
        let path = entry.unwrap().path();
        let text = fs::read_to_string(&path).unwrap();
        assert!(text.contains(from), "{} has no `{from}`", path.display());
        fs::write(path, text.replacen(from, to, 1)).unwrap();
    }
    folder
}

/// The samples in `out/measured/ingest.json`.
fn samples(folder: &TempDir) -> u64 {
    json(folder, "out/measured/ingest.json")["data"]["samples"].as_u64().unwrap()
}

const NEW: &str = "new mine --vessel model-ship --logs logs";
const INGEST: &str = "run mine --out out --quiet --stage ingest";

#[test]
fn logs_come_to_their_page_by_two_commands() {
    let folder = logged("heading", "heading");
    let ran = run(&folder, NEW).succeeds();
    assert!(ran.stdout.contains("55 logs") && ran.stdout.contains("0 channels missing"), "{ran}");
    run(&folder, "run mine --out out --quiet").succeeds();
    let page = String::from_utf8(bytes(&folder, "out/measured/report.html")).unwrap();
    assert!(page.contains("<svg"), "measured is shown against simulated");
    assert!(samples(&folder) > 55 * 70, "{}", samples(&folder));
    // What is there is up to date, and a changed log is not
    let again = run(&folder, "run mine --out out --quiet").succeeds();
    assert!(again.stdout.contains(": 0 of 6 stages run"), "{again}");
    let log = fs::read_dir(folder.path().join("logs")).unwrap().next().unwrap().unwrap().path();
    let text = fs::read_to_string(&log).unwrap();
    fs::write(&log, text.trim_end().rsplit_once('\n').unwrap().0).unwrap();
    let changed = run(&folder, INGEST).succeeds();
    assert!(changed.stdout.contains(": 1 of 1 stages run"), "{changed}");
}

#[test]
fn what_was_guessed_is_marked_on_its_line() {
    let folder = logged("heading [deg]", "heading");
    run(&folder, NEW).succeeds();
    let text = String::from_utf8(bytes(&folder, "mine/ingest.toml")).unwrap();
    for line in [
        "channel = \"psi\"  # guessed",
        "unit = \"deg\"  # guessed",
        "frame = \"ned\"  # guessed",
        "max_gap_s = 0.62  # guessed",
    ] {
        assert!(text.contains(line), "no `{line}` in\n{text}");
    }
    assert!(text.contains("unit = \"rpm\"\n") && text.contains("channel = \"alpha_2\""), "{text}");
}

#[test]
fn columns_of_parquet_are_recognised() {
    let folder = tempfile::tempdir().unwrap();
    fs::create_dir(folder.path().join("logs")).unwrap();
    for name in ["a_thruster.parquet", "b_thruster.parquet"] {
        fs::copy(repository().join("fixtures/logs").join(name), folder.path().join("logs").join(name))
            .unwrap();
    }
    let ran = run(&folder, "new mine --vessel esso-osaka --logs logs").succeeds();
    assert!(ran.stdout.contains("2 logs"), "{ran}");
    let text = String::from_utf8(bytes(&folder, "mine/ingest.toml")).unwrap();
    for piece in [
        "2 files in Parquet",
        "pattern = [\"*.parquet\"]",
        "# A row about every 0.25 s.\n[file.time]\ncolumn = \"t_ns\"\nunit = \"ns\"  # guessed",
        "column = \"rpm\"\nchannel = \"n\"",
    ] {
        assert!(text.contains(piece), "no `{piece}` in\n{text}");
    }
    put(&folder, "logs/b_thruster.parquet", "PAR1");
    refused(&folder, 3, "new other --vessel esso-osaka --logs logs", &["logs/b_thruster.parquet: "]);
}

#[test]
fn a_column_that_is_not_placed_is_listed_and_works_once_it_is_named() {
    let folder = logged("thruster 1 [rpm]", "port [rpm]");
    let ran = run(&folder, NEW).succeeds();
    assert!(ran.stdout.contains("1 channels missing"), "{ran}");
    let text = String::from_utf8(bytes(&folder, "mine/ingest.toml")).unwrap();
    assert!(text.contains("#   \"port [rpm]\"\n"), "{text}");
    run(&folder, INGEST).refuses(3, &["n_1"]);
    let template = "# [[file.channel]]\n# column = \"\"\n# channel = \"n_1\"\n# unit = \"1/s\"\n";
    let named = "[[file.channel]]\ncolumn = \"port [rpm]\"\nchannel = \"n_1\"\nunit = \"rpm\"\n";
    edit(&folder, "mine/ingest.toml", template, named);
    run(&folder, INGEST).succeeds();
}

#[test]
fn law_a_wrong_guess_works_once_it_is_corrected() {
    let right = logged("heading", "heading");
    run(&right, NEW).succeeds();
    run(&right, INGEST).succeeds();
    // Degrees below a turn's 6.28, and no unit: they could be radians.
    let wrong = logged("thruster 1 [deg]", "azimuth 1");
    run(&wrong, NEW).succeeds();
    run(&wrong, INGEST).succeeds();
    let summary = |folder: &TempDir| json(folder, "out/measured/ingest.json");
    let channels = |folder: &TempDir| summary(folder)["data"]["recordings"][0]["channels"].clone();
    assert_ne!(channels(&wrong), channels(&right), "the guess is wrong");
    edit(
        &wrong,
        "mine/ingest.toml",
        "unit = \"rad\"  # guessed: the column's name says none",
        "unit = \"deg\"",
    );
    run(&wrong, INGEST).succeeds();
    assert_eq!(channels(&wrong), channels(&right));
    assert!(channels(&right).as_array().unwrap().len() > 7);
    assert_eq!(samples(&wrong), samples(&right));
}

#[test]
#[ignore = "long: `make nightly` runs it"]
fn published_logs_come_to_their_page_by_two_commands() {
    let logs = repository().join("../shared/data/kvlcc2_hsva");
    if !logs.is_dir() {
        println!("skipped: there is no {}", logs.display());
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let ran = run(&folder, &format!("new mine --vessel kvlcc2 --logs {}", logs.display())).succeeds();
    assert!(ran.stdout.contains("13 logs") && ran.stdout.contains("0 channels missing"), "{ran}");
    edit(&folder, "mine/study.mk", "BOOTSTRAP ?= 100", "BOOTSTRAP ?= 8");
    run(&folder, "run mine --out out --quiet").succeeds();
    let page = String::from_utf8(bytes(&folder, "out/measured/report.html")).unwrap();
    assert!(page.contains("KVLCC2") && page.contains("<svg"));
    let document = json(&folder, "out/measured/ingest.json");
    assert_eq!(
        (document["data"]["runs"].as_u64(), document["data"]["samples"].as_u64()),
        (Some(13), Some(2120))
    );
}
