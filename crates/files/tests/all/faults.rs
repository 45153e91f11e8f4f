//! Sets of files after faults at every place where one can be: all old or all new, and nothing beside them.

use std::path::Path;
use std::process::Command;

use files::fault::{Fault, inject};
use files::{Error, Staged, TableReader, commit, read_document, read_written, stage_document};

use crate::sample::{Design, design, encode, folder, names, provenance, stage};

/// Environment variables that [`set_of_another_process`] reads.
const FOLDER: &str = "ARTIFACT_TEST_FOLDER";
const COUNT: &str = "ARTIFACT_TEST_COUNT";
const KILL: &str = "ARTIFACT_TEST_KILL";
/// At which place after the fault the process is killed.
const THEN: &str = "ARTIFACT_TEST_THEN";

/// Writes a table of `blocks` blocks, a document that says how many, and a picture.
fn write_set(folder: &Path, blocks: usize) -> Result<(), Error> {
    let table = stage(&folder.join("t.parquet"), &provenance(), encode(0..blocks))?;
    let document =
        stage_document(folder.join("t.json"), &provenance(), &Design { gap: blocks as f64, ..design() })?;
    let picture = Staged::bytes(folder.join("t.svg"), blocks.to_string().as_bytes())?;
    commit(vec![table, document, picture])
}

/// How many blocks each file of the set in `folder` is of.
fn read_set(folder: &Path) -> [usize; 3] {
    let table = TableReader::open(folder.join("t.parquet"), "trajectories", 2).unwrap().blocks();
    let document = read_document::<Design>(folder.join("t.json")).unwrap().data.gap as usize;
    let picture = read_written(folder.join("t.svg")).unwrap();
    let picture = String::from_utf8(picture).unwrap().parse().unwrap();
    [table, document, picture]
}

/// Not a test of its own: the process that [`faulty`] starts.
#[test]
fn set_of_another_process() {
    let Ok(folder) = std::env::var(FOLDER) else { return };
    let fault = if std::env::var(KILL).is_ok() { Fault::Kill } else { Fault::Error };
    inject(fault, std::env::var(COUNT).unwrap().parse().unwrap());
    if let Ok(then) = std::env::var(THEN) {
        inject(Fault::Kill, then.parse().unwrap());
    }
    write_set(Path::new(&folder), 2).unwrap();
}

/// Writes the set in another process, which meets `fault` at place `count`; whether it came to its end.
fn faulty(folder: &Path, fault: Fault, count: u32) -> bool {
    let mut child = Command::new(std::env::current_exe().unwrap());
    child.args(["faults::set_of_another_process", "--exact", "--test-threads=1"]);
    child.env(FOLDER, folder).env(COUNT, count.to_string());
    if fault == Fault::Kill {
        child.env(KILL, "1");
    }
    child.output().unwrap().status.success()
}

/// Writes the set in another process, which meets an error at place `count` and is killed at place `then` after it; whether
/// it came so far.
#[cfg(unix)]
fn killed_after_error(folder: &Path, count: u32, then: u32) -> bool {
    use std::os::unix::process::ExitStatusExt;
    let mut child = Command::new(std::env::current_exe().unwrap());
    child.args(["faults::set_of_another_process", "--exact", "--test-threads=1"]);
    child.env(FOLDER, folder).env(COUNT, count.to_string()).env(THEN, then.to_string());
    child.output().unwrap().status.signal().is_some()
}

/// At how many places `fault` left the old set, and at how many the new one.
fn after_every(fault: Fault) -> [u32; 2] {
    let mut counted = [0; 2];
    for count in 1.. {
        let folder = folder();
        write_set(folder.path(), 1).unwrap();
        let ended = faulty(folder.path(), fault, count);
        let found = read_set(folder.path());
        assert!(found == [1; 3] || found == [2; 3], "place {count}: {found:?}");
        counted[usize::from(found == [2; 3])] += 1;
        assert!(fault == Fault::Kill || ended == (found == [2; 3]), "place {count}");
        if fault == Fault::Kill {
            // The next process to write there clears away what the killed one left.
            assert!(faulty(folder.path(), Fault::Error, u32::MAX), "place {count}");
        }
        assert_eq!(names(&folder), ["t.json", "t.parquet", "t.svg"], "place {count}");
        if ended {
            break;
        }
    }
    counted
}

#[test]
fn law_a_killed_process_leaves_the_old_set_or_the_new_one() {
    let [old, new] = after_every(Fault::Kill);
    assert!(old > 10 && new > 4, "{old} {new}");
}

#[test]
fn law_a_process_that_fails_leaves_the_old_set() {
    let [old, new] = after_every(Fault::Error);
    assert!(old > 10 && new == 1, "{old} {new}");
}

#[cfg(unix)]
#[test]
fn law_a_process_killed_while_it_gives_names_back_leaves_the_old_set() {
    // The last places of a set that is written to its end: flush, forget and flush are behind its last rename.
    let last = (1..).find(|count| faulty(folder_with_set().path(), Fault::Kill, *count)).unwrap() - 1;
    let mut killed = 0;
    for count in last.saturating_sub(8)..=last {
        for then in 1.. {
            let folder = folder_with_set();
            // A file that none had the name of before.
            std::fs::remove_file(folder.path().join("t.svg")).unwrap();
            if !killed_after_error(folder.path(), count, then) {
                break;
            }
            killed += 1;
            let table =
                TableReader::open(folder.path().join("t.parquet"), "trajectories", 2).unwrap().blocks();
            let document = read_document::<Design>(folder.path().join("t.json")).unwrap().data.gap as usize;
            let picture = read_written(folder.path().join("t.svg")).ok();
            let found = (table, document, picture.as_deref());
            assert!(found == (1, 1, None) || found == (2, 2, Some(b"2")), "{count}, {then}: {found:?}");
            assert!(faulty(folder.path(), Fault::Error, u32::MAX));
            assert_eq!(names(&folder), ["t.json", "t.parquet", "t.svg"], "{count}, {then}");
        }
    }
    assert!(killed > 20, "{killed}");
}

#[cfg(unix)]
fn folder_with_set() -> tempfile::TempDir {
    let folder = folder();
    write_set(folder.path(), 1).unwrap();
    folder
}
