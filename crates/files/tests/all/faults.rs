//! Sets of files after faults at every place where one can be: all old, all new, or refused until the next run.

use std::path::Path;
use std::process::Command;

use files::fault::{Fault, inject};
use files::{Error, Staged, TableReader, TableWriter, commit, read, read_document, stage_set_document};

use crate::sample::{Design, design, encode, folder, names, provenance, schema};

/// Environment variables that [`set_of_another_process`] reads.
const FOLDER: &str = "ARTIFACT_TEST_FOLDER";
const COUNT: &str = "ARTIFACT_TEST_COUNT";
const KILL: &str = "ARTIFACT_TEST_KILL";

/// Writes a table of `blocks` blocks, a picture, and a document that says how many and vouches for both.
fn write_set(folder: &Path, blocks: usize) -> Result<(), Error> {
    let path = folder.join("t.json");
    let mut writer =
        TableWriter::create(folder.join("t.parquet"), &schema(), &provenance())?.with_document(&path);
    encode(0..blocks).into_iter().try_for_each(|block| writer.push(block))?;
    let picture = Staged::bytes(folder.join("t.svg"), blocks.to_string().as_bytes())?;
    let mut files = vec![writer.finish()?, picture];
    let document = Design { gap: blocks as f64, ..design() };
    files.push(stage_set_document(path, &provenance(), &document, &files)?);
    commit(files)
}

/// How many blocks each file of the set in `folder` is of; the error of its document, or else of its table.
fn read_set(folder: &Path) -> Result<[usize; 3], Error> {
    let document = read_document::<Design>(folder.join("t.json"))?.data.gap as usize;
    let table = TableReader::open(folder.join("t.parquet"), "trajectories", 2)?.blocks();
    let picture = String::from_utf8(read(folder.join("t.svg"))?).unwrap().parse().unwrap();
    Ok([table, document, picture])
}

/// Not a test of its own: the process that [`faulty`] starts.
#[test]
fn set_of_another_process() {
    let Ok(folder) = std::env::var(FOLDER) else { return };
    let fault = if std::env::var(KILL).is_ok() { Fault::Kill } else { Fault::Error };
    inject(fault, std::env::var(COUNT).unwrap().parse().unwrap());
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

/// At how many places `fault` left the old set, a refused one, and the new one.
fn after_every(fault: Fault) -> [u32; 3] {
    let mut counted = [0; 3];
    for count in 1.. {
        let folder = folder();
        write_set(folder.path(), 1).unwrap();
        let ended = faulty(folder.path(), fault, count);
        let found = read_set(folder.path());
        let state = match &found {
            Ok([1, 1, 1]) => 0,
            Err(Error::Refused { invalid, .. }) if invalid.to_string().contains("run the stage that") => 1,
            Ok([2, 2, 2]) => 2,
            _ => panic!("place {count}: {found:?}"),
        };
        counted[state] += 1;
        assert!(!ended || state == 2, "place {count}");
        if fault == Fault::Kill {
            // The next process to write there clears away what the killed one left.
            assert!(faulty(folder.path(), Fault::Error, u32::MAX), "place {count}");
            assert_eq!(read_set(folder.path()).unwrap(), [2; 3], "place {count}");
        }
        assert_eq!(names(&folder), ["t.json", "t.parquet", "t.svg"], "place {count}");
        if ended {
            break;
        }
    }
    counted
}

#[test]
fn law_a_killed_process_leaves_the_old_set_or_the_new_one_or_one_that_is_refused() {
    let [old, refused, new] = after_every(Fault::Kill);
    assert!(old > 10 && refused == 2 && new == 2, "{old} {refused} {new}");
}

#[test]
fn law_a_process_that_fails_before_it_renames_leaves_the_old_set() {
    let [old, refused, new] = after_every(Fault::Error);
    assert!(old > 10 && refused == 2 && new == 1, "{old} {refused} {new}");
}

#[test]
fn only_leftovers_of_ended_processes_are_removed() {
    let folder = folder();
    assert!(!faulty(folder.path(), Fault::Kill, 3));
    let of_ended = names(&folder).pop().unwrap();
    let parts: Vec<&str> = of_ended.split('-').collect();
    let name = |machine: &str, process: u32| format!(".unfinished-{machine}-{process}-abcdef.seatrial");
    let ended = parts[2].parse().unwrap();
    // Of this process, of another machine, and of a user.
    let kept =
        [name(parts[1], std::process::id()), name("elsewhere", ended), name("", ended).replace(".s", ".t")];
    let old = name("elsewhere", ended).replace("abc", "ABC");
    for name in kept.iter().chain([&old]) {
        std::fs::write(folder.path().join(name), b"x").unwrap();
    }
    let eight_days = std::time::Duration::from_secs(8 * 24 * 3600);
    let file = std::fs::File::options().write(true).open(folder.path().join(&old)).unwrap();
    file.set_modified(std::time::SystemTime::now() - eight_days).unwrap();
    assert!(faulty(folder.path(), Fault::Error, u32::MAX));
    let found: Vec<String> = names(&folder).into_iter().filter(|name| !name.starts_with("t.")).collect();
    let mut kept = kept.to_vec();
    kept.sort();
    assert_eq!(found, kept);
}
