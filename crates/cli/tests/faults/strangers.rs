//! Foreign files in a folder: forged journals of sets, pipes with names of files, locks.

#![cfg(unix)]

use std::fs;
use std::os::unix::fs::symlink;
use std::path::Path;
use std::process::Command;
use std::time::{Duration, Instant};

use files::Digest;
use tempfile::TempDir;

use crate::ends::{Fault, Tally, Wrong, start, wait};
use crate::grounds::Stage;
use crate::places::Place;
use crate::points::for_every_stage;
use crate::support::{DESIGN, ESTIMATE, MADE, SEATRIAL, put, run, with};

const THESIS: &str = "ten years of work";

/// A journal with a valid seal.
fn sealed(renames: &str) -> String {
    let blank = format!("blake3:{}", "0".repeat(64));
    let text = format!("{{\"schema\": \"set/2\", \"seal\": \"{blank}\", \"renames\": [{renames}]}}");
    let seal = Digest::of_bytes(text.as_bytes());
    text.replacen(&blank, &seal.to_string(), 1)
}

/// A name that the program may give, and one of a user.
const HIDDEN: &str = ".unfinished-abcdef.seatrial";
const NOVEL: &str = ".unfinished-novel.txt";

fn number(path: &Path) -> u64 {
    std::os::unix::fs::MetadataExt::ino(&fs::metadata(path).unwrap())
}

/// Journals that ask for renames: in the old format without seals, and with a valid seal. `home` is a folder next to
/// that of the journal, and `elsewhere` in the latter a link to it. `own` is the number of the thesis beside the journal.
fn journals(home: &Path, own: u64) -> Vec<String> {
    let number = number(&home.join("thesis.docx"));
    let digest = Digest::of_bytes(THESIS.as_bytes());
    let home = home.display();
    let renames = [
        ("elsewhere/thesis.docx".to_owned(), format!("elsewhere/{HIDDEN}"), number),
        ("../home/thesis.docx".to_owned(), format!("../home/{HIDDEN}"), number),
        (format!("{home}/thesis.docx"), format!("{home}/{HIDDEN}"), number),
        ("thesis.docx".to_owned(), HIDDEN.to_owned(), own),
        ("linked.docx".to_owned(), HIDDEN.to_owned(), number),
    ];
    let plain = renames.iter().map(|(from, to, _)| format!("[[\"{from}\", \"{to}\"]]"));
    let entry = |(from, to, number): &(String, String, u64), digest| {
        sealed(&format!(
            "{{\"from\": \"{from}\", \"to\": \"{to}\", \"digest\": \"{digest}\", \"number\": {number}}}"
        ))
    };
    let fitting = renames.iter().filter(|(from, ..)| from != "thesis.docx").map(|own| entry(own, digest));
    let other = entry(&renames[3], Digest::of_bytes(b"another"));
    // Who packs a folder for somebody else knows no number of its files there.
    let foreign = |from: &str, to: &str| entry(&(from.to_owned(), to.to_owned(), own + 1), digest);
    let hiding = foreign("thesis.docx", HIDDEN);
    // And no journal names a file that this program did not name.
    let novel = entry(&("thesis.docx".to_owned(), NOVEL.to_owned(), own), digest);
    plain.chain(fitting).chain([other, hiding, novel]).collect()
}

/// Plants every journal in `folder`, the files to rename, and the link.
fn plant(folder: &Path, home: &Path) {
    symlink(home, folder.join("elsewhere")).unwrap();
    symlink(home.join("thesis.docx"), folder.join("linked.docx")).unwrap();
    fs::write(folder.join("thesis.docx"), THESIS).unwrap();
    fs::write(folder.join(NOVEL), THESIS).unwrap();
    for (i, journal) in journals(home, number(&folder.join("thesis.docx"))).iter().enumerate() {
        fs::write(folder.join(format!(".unfinished-set-{i:06}.seatrial")), journal).unwrap();
    }
}

/// Whether all files to rename are where they were.
fn untouched(folder: &Path, home: &Path) -> bool {
    let is_there = |path: &Path| fs::read(path).is_ok_and(|bytes| bytes == THESIS.as_bytes());
    let alone = fs::read_dir(home).unwrap().count() == 1;
    alone
        && [
            folder.join("thesis.docx"),
            folder.join("linked.docx"),
            home.join("thesis.docx"),
            folder.join(NOVEL),
        ]
        .iter()
        .all(|p| is_there(p))
}

/// A folder next to `folder` with a thesis.
fn home_of(folder: &Path) -> std::path::PathBuf {
    let home = folder.join("home");
    fs::create_dir(&home).unwrap();
    fs::write(home.join("thesis.docx"), THESIS).unwrap();
    home
}

#[test]
fn no_stage_obeys_a_journal_that_a_stranger_planted() {
    for_every_stage("planted journals", |_, ground, stage| {
        let place = Place::on(ground);
        let home = home_of(place.path());
        let out = place.path().join("out");
        [place.path(), &out].into_iter().for_each(|folder| plant(folder, &home));
        let line = stage.line_into("out/");
        let ended = wait(&place, start(&place, &line, ""));
        let fine = [place.path(), &out].into_iter().all(|folder| untouched(folder, &home));
        let found = match ended.judged() {
            Ok(_) if !fine => Err((Wrong::Mixed, "it obeyed a stranger".to_owned())),
            Ok(0) => Ok(true),
            Ok(code) if stage.out.is_empty() => Ok(code == 3),
            other => other.and_then(|code| Err((Wrong::Other, format!("exit code {code}: {}", ended.told)))),
        };
        let mut tally = Tally::default();
        tally.fault(&line, found);
        tally
    });
}

#[test]
fn verify_obeys_no_journal_and_says_that_it_is_none() {
    let top = with(&MADE);
    let home = home_of(top.path());
    let folder = top.path().join("results");
    fs::create_dir(&folder).unwrap();
    fs::copy(top.path().join("design.json"), folder.join("design.json")).unwrap();
    plant(&folder, &home);
    // One with a valid seal and names of this kind looks like that of an interrupted run.
    let said = run(&top, "verify results");
    assert_eq!(said.code, Some(3), "{said}");
    assert!(format!("{}{}", said.stdout, said.stderr).contains("a run that was interrupted"), "{said}");
    assert!(
        said.stdout.contains("`.unfinished-set-000000.seatrial`, that no stage wrote as it is"),
        "{said}"
    );
    assert!(untouched(&folder, &home), "{said}");
}

#[test]
fn leftovers_of_a_killed_clean_up_are_no_documents() {
    let folder = with(&MADE);
    let design = fs::read(folder.path().join("design.json")).unwrap();
    for (name, length) in [("old-x1y2z3", design.len()), ("x1y2z3", 10), ("cut123", 200)] {
        fs::write(folder.path().join(format!(".unfinished-{name}.seatrial")), &design[..length]).unwrap();
    }
    let novels = [NOVEL, ".unfinished-chapter2.seatrial", ".unfinished-set-of-six", ".unfinished-abcdef"];
    novels.iter().for_each(|name| fs::write(folder.path().join(name), THESIS).unwrap());
    let said = run(&folder, "verify .").succeeds();
    let line = ".: 3 hidden leftovers, removed by the next stage that writes here";
    assert!(said.stdout.lines().any(|own| own == line), "{said}");
    run(&folder, DESIGN).succeeds();
    assert!(!run(&folder, "verify .").succeeds().stdout.contains("hidden leftover"));
    // A user's own files are none.
    for name in novels {
        assert_eq!(fs::read_to_string(folder.path().join(name)).unwrap(), THESIS, "{name}");
    }
}

#[test]
fn verify_renames_nothing_of_a_set_that_is_half_named() {
    let folder = with(&["campaign.parquet", "estimates.parquet", "estimate.json"]);
    let estimate = format!("{ESTIMATE} --estimator ls");
    let mut half_named = 0;
    for count in (1..64).step_by(2) {
        let mut command = Command::new(SEATRIAL);
        command.args(estimate.split_whitespace()).current_dir(&folder);
        let ended = command.env("SEATRIAL_FAULT", format!("kill:{count}")).output().unwrap();
        if ended.status.success() {
            break;
        }
        let before = crate::support::listing(folder.path());
        let said = run(&folder, "verify .");
        assert_eq!(crate::support::listing(folder.path()), before, "{said}");
        if before.keys().any(|path| path.to_string_lossy().contains(".unfinished-set-")) {
            half_named += 1;
            assert_eq!(said.code, Some(3), "{said}");
            assert!(said.stdout.contains("set: found a run that was interrupted"), "{said}");
        } else {
            said.succeeds();
        }
    }
    assert!(half_named > 2, "{half_named}");
    run(&folder, &estimate).succeeds();
    let said = run(&folder, "verify .");
    assert!(!said.stdout.contains("interrupted") && !said.stdout.contains("leftover"), "{said}");
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
    make_pipe(&folder.path().join(".unfinished-set-abcdef.seatrial"));
    make_pipe(&folder.path().join(HIDDEN));
    let started = Instant::now();
    let said = run(&folder, "verify .");
    assert!(started.elapsed() < Duration::from_secs(20));
    assert_eq!(said.code, Some(3), "{said}");
    assert!(said.stdout.contains("fault: ./x.json: file: found a pipe"), "{said}");
    assert!(said.stdout.contains("fault: ./x.parquet: file: found a pipe"), "{said}");
    run(&folder, DESIGN).succeeds();
}

/// A folder whose lock this process holds for as long as the file is kept.
fn held(names: &[&str]) -> (TempDir, fs::File) {
    let folder = with(names);
    let lock = fs::File::open(folder.path()).unwrap();
    lock.lock().unwrap();
    (folder, lock)
}

#[test]
fn a_folder_that_another_process_holds_is_waited_for_only_so_long() {
    let (folder, _lock) = held(&["campaign.parquet"]);
    let mut command = Command::new(SEATRIAL);
    command.args(format!("{ESTIMATE} --estimator ls --quiet").split_whitespace()).current_dir(&folder);
    let output = command.env("SEATRIAL_PATIENCE_S", "2").output().unwrap();
    let told = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(1), "{told}");
    assert!(told.contains(".: waits for another process that holds this folder"), "{told}");
    assert!(told.contains("error: .: lock: found another process that has held its lock for 2 s"), "{told}");
    assert!(told.contains("; end that process"), "{told}");
    // One file needs no lock.
    run(&folder, "simulate validation --vessel vessel.toml --campaign campaign.toml --out v.parquet")
        .succeeds();
}

#[test]
fn signals_end_a_wait_for_a_folder_at_once() {
    for (signal, code) in [("TERM", 143), ("INT", 130)] {
        let (folder, _lock) = held(&["campaign.parquet"]);
        let before = crate::support::listing(folder.path());
        let said = tempfile::NamedTempFile::new().unwrap();
        let mut command = Command::new(SEATRIAL);
        command.args(format!("{ESTIMATE} --estimator ls --quiet").split_whitespace()).current_dir(&folder);
        let mut child = command.stderr(said.reopen().unwrap()).spawn().unwrap();
        let started = Instant::now();
        while !fs::read_to_string(said.path()).unwrap().contains("waits") {
            assert!(started.elapsed() < Duration::from_secs(45) && child.try_wait().unwrap().is_none());
            std::thread::sleep(Duration::from_millis(5));
        }
        let sent = Instant::now();
        Command::new("kill").args(["-s", signal, &child.id().to_string()]).status().unwrap();
        assert_eq!(child.wait().unwrap().code(), Some(code), "{signal}");
        assert!(sent.elapsed() < Duration::from_secs(10), "{signal}");
        let mut after = crate::support::listing(folder.path());
        after.retain(|path, _| !before.contains_key(path));
        assert!(after.is_empty(), "{signal} leaves {after:?}");
    }
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
