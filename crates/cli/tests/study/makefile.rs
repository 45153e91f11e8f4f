//! `make` with names that a shell would misinterpret.

use std::process::Command;

use crate::support::*;

/// `make -n` in the repository.
fn make() -> Command {
    let mut command = Command::new("make");
    command.args(["--no-print-directory", "-n"]).current_dir(repository());
    // Not those of a make that runs the tests.
    for name in ["MAKEFLAGS", "MAKELEVEL", "MFLAGS"] {
        command.env_remove(name);
    }
    command
}

/// Exit code and what `make -n` says with a variable, on the command line or in the environment.
fn made(variable: &str, in_environment: bool) -> (Option<i32>, String) {
    let mut command = make();
    command.arg("study");
    match (variable.split_once('='), in_environment) {
        (Some((name, value)), true) => command.env(name, value),
        _ => command.arg(variable),
    };
    let output = command.output().unwrap();
    (output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned())
}

#[test]
fn names_that_a_shell_takes_for_more_are_refused_by_make() {
    if Command::new("make").arg("--version").output().is_err() {
        println!("skipped: there is no make");
        return;
    }
    for (variable, found) in [
        ("STUDY=a b", "a[blank]b"),
        ("STUDY=pipelines/a&b", "pipelines/a&b"),
        ("STUDY=pipelines/{x}", "pipelines/{x}"),
        ("STUDY=$(shell touch made)", "$(shell[blank]touch[blank]made)"),
        ("STUDY=-f", "-f"),
        ("OUT=x;y", "x;y"),
        ("LOGS=my logs", "my[blank]logs"),
        ("SWEEP=a`b", "a`b"),
        ("SWEEP_OUT=a>b", "a>b"),
        ("PROFILE=a|b", "a|b"),
        ("DICTIONARY=a'b", "a'b"),
        ("BIN=a\tb", "a[blank]b"),
    ] {
        for in_environment in [false, true] {
            let (code, said) = made(variable, in_environment);
            let name = variable.split('=').next().unwrap();
            let expected = format!("{name}: found `{found}`, expected a name of letters, digits");
            assert!(code == Some(2) && said.contains(&expected), "{variable}: {code:?} {said}");
            assert_eq!(said.lines().count(), 1, "{said}");
        }
    }
    assert!(!repository().join("made").exists());
    let (code, said) = made("STUDY=pipelines/smoke", false);
    assert_eq!(code, Some(0), "{said}");
}

/// The commands that make would run with `words`, whether or not there is anything to do for them.
fn commands(words: &[&str]) -> String {
    let output = make().arg("-B").args(words).output().unwrap();
    assert!(output.status.success(), "{words:?}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

/// `text` with one blank wherever there are several.
fn one_blank(text: &str) -> String {
    text.split(' ').filter(|word| !word.is_empty()).collect::<Vec<_>>().join(" ")
}

#[test]
fn make_runs_the_study_that_is_named() {
    if Command::new("make").arg("--version").output().is_err() {
        println!("skipped: there is no make");
        return;
    }
    // A folder of logs, without a study.toml
    let folder = tempfile::Builder::new().prefix("logged").tempdir().unwrap();
    for name in ["vessel.toml", "ingest.toml"] {
        put(&folder, name, "");
    }
    std::fs::create_dir(folder.path().join("logs")).unwrap();
    let place = folder.path().display();
    let said = commands(&[&format!("STUDY={place}"), &format!("LOGS={place}/logs"), "OUT=out/logged"]);
    let piece = format!("seatrial run {place} --logs {place}/logs --out out/logged");
    assert!(
        one_blank(&said).contains(&piece) && said.contains("Report: out/logged/measured/report.html"),
        "{said}"
    );
    let further = ["STUDY=pipelines/smoke", "STAGE=design", "FLAGS=--quiet"];
    let piece = "run pipelines/smoke --quiet --stage design --out out/smoke";
    assert!(one_blank(&commands(&further)).contains(piece), "{}", commands(&further));
    let own = commands(&["STUDY=pipelines/smoke", "sequential"]);
    for piece in ["monte-carlo --vessel pipelines/smoke/vessel.toml", "--results out/smoke/sequential"] {
        assert!(own.contains(piece), "no `{piece}` in\n{own}");
    }
    assert!(commands(&["sequential"]).contains("--campaign pipelines/sequential/campaign.toml"));
    // What was set so before study.toml is not passed over.
    let (code, said) = made("DESIGN_FLAGS=--segments 5", false);
    assert!(
        code == Some(2) && said.contains("DESIGN_FLAGS: found it") && said.contains("--set study.design"),
        "{said}"
    );
    // A folder that is not there is named before anything is built.
    let (code, said) = made("STUDY=pipelines/none", false);
    assert!(code == Some(2) && said.contains("pipelines/none: found no such folder"), "{said}");
}
