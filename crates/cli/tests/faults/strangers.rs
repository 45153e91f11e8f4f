//! Foreign files in a folder: pipes with names of files, files of a user with names like ours.

#![cfg(unix)]

use std::fs;
use std::path::Path;
use std::process::Command;
use std::time::{Duration, Instant};

use crate::ends::{Fault, Tally, Wrong, start, wait};
use crate::grounds::Stage;
use crate::places::Place;
use crate::points::for_every_stage;
use crate::support::{DESIGN, MADE, SEATRIAL, put, run, with};
use files::Digest;

/// A name that the program may give, and one of a user.
const HIDDEN: &str = ".unfinished-0-1-abcdef.seatrial";
const NOVEL: &str = ".unfinished-novel.txt";

#[test]
fn unfinished_files_are_no_documents_and_those_of_a_user_stay() {
    let folder = with(&MADE);
    let design = fs::read(folder.path().join("design.json")).unwrap();
    let mut command = Command::new(SEATRIAL);
    command.args(DESIGN.split_whitespace()).current_dir(&folder).env("SEATRIAL_FAULT", "kill:2");
    assert!(!command.output().unwrap().status.success());
    let novels = [NOVEL, ".unfinished-chapter2.seatrial", ".unfinished-set-of-six", ".unfinished-abcdef"];
    novels.iter().for_each(|name| fs::write(folder.path().join(name), &design[..9]).unwrap());
    let said = run(&folder, "verify .").succeeds();
    let line = ".: 1 unfinished, removed by the next stage that writes here if its process has ended";
    assert!(said.stdout.lines().any(|own| own == line), "{said}");
    run(&folder, DESIGN).succeeds();
    assert!(!run(&folder, "verify .").succeeds().stdout.contains("unfinished"));
    for name in novels {
        assert_eq!(fs::read(folder.path().join(name)).unwrap(), design[..9], "{name}");
    }
}

/// Replaces a file by a pipe without a writer.
fn make_pipe(path: &Path) {
    let _ = fs::remove_file(path);
    assert!(Command::new("mkfifo").arg(path).status().unwrap().success());
}

/// How a stage ends that finds a pipe in place of a file.
fn with_pipe(place: &Place, stage: &Stage, name: &str) -> Result<bool, Fault> {
    let path = place.path().join(name);
    make_pipe(&path);
    let line = stage.line_into("out/");
    let ended = wait(place, start(place, &line, ""));
    fs::remove_file(&path).unwrap();
    fs::write(&path, place.original(name)).unwrap();
    match ended.judged()? {
        3 if ended.told.contains("file: found a pipe, expected an ordinary file") => Ok(false),
        code => Err((Wrong::Other, format!("{name}: exit code {code}: {}", ended.told))),
    }
}

#[test]
fn no_stage_waits_for_a_pipe_in_place_of_a_file() {
    for_every_stage("pipes", |_, ground, stage| {
        let place = Place::on(ground);
        let mut tally = Tally::default();
        for name in stage.reads {
            tally.fault(&stage.line_into("out/"), with_pipe(&place, stage, name));
        }
        tally
    });
}

#[test]
fn folders_sockets_and_devices_are_no_files() {
    let folder = with(&["moments.json"]);
    let path = folder.path().join("moments.json");
    fs::remove_file(&path).unwrap();
    fs::create_dir(&path).unwrap();
    run(&folder, DESIGN).refuses(3, &["moments.json: file: found a folder, expected an ordinary file"]);
    fs::remove_dir(&path).unwrap();
    let _listening = std::os::unix::net::UnixListener::bind(&path).unwrap();
    run(&folder, DESIGN).refuses(3, &["moments.json: file: found a socket"]);
    run(&folder, "design --moments /dev/zero --out design.json")
        .refuses(3, &["/dev/zero: file: found a device"]);
    let campaign = "simulate validation --vessel /dev/tty --campaign campaign.toml --out validation.parquet";
    run(&folder, campaign).refuses(3, &["/dev/tty: file: found a device"]);
}

#[test]
fn verify_waits_for_no_pipe() {
    let folder = with(&MADE);
    make_pipe(&folder.path().join("x.json"));
    make_pipe(&folder.path().join("x.parquet"));
    make_pipe(&folder.path().join(HIDDEN));
    let started = Instant::now();
    let said = run(&folder, "verify .");
    assert!(started.elapsed() < Duration::from_secs(20));
    assert_eq!(said.code, Some(3), "{said}");
    assert!(said.stdout.contains("fault: ./x.json: file: found a pipe"), "{said}");
    assert!(said.stdout.contains("fault: ./x.parquet: file: found a pipe"), "{said}");
    run(&folder, DESIGN).succeeds();
}

#[test]
fn members_of_other_folders_are_refused() {
    let folder = with(&["moments.json"]);
    let text = fs::read_to_string(folder.path().join("moments.json")).unwrap();
    let digest = Digest::of_bytes(b"x");
    let seal = text.find("\"seal\": ").unwrap();
    let end = seal + text[seal..].find(',').unwrap();
    let text = format!("{}\"seal\": null{}", &text[..seal], &text[end..]);
    put(
        &folder,
        "moments.json",
        &text.replacen("\"units\":", &format!("\"members\": {{\"../x\": \"{digest}\"}}, \"units\":"), 1),
    );
    run(&folder, DESIGN)
        .refuses(3, &["moments.json: members: found `../x`, expected files beside the document"]);
}
