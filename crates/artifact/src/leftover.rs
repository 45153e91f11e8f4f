//! What processes leave in a folder that end before they are done: files without names, sets half renamed.

use std::fs::{self, File, OpenOptions};
use std::path::Path;

use crate::journal::{self, Journal};
use crate::names::UNFINISHED;

/// Completes half renamed sets in `folder` and removes the unfinished files of processes that are no more.
///
/// Errors are ignored: a folder that cannot be repaired stays as it was.
pub(crate) fn sweep(folder: &Path) {
    if unfinished(folder).is_empty() {
        return;
    }
    let Some(_held) = hold(folder) else { return };
    complete(folder);
    for name in unfinished(folder) {
        let path = folder.join(&name);
        // Whoever still writes it holds its lock; where there are no locks, it stays.
        let file = OpenOptions::new().read(true).write(true).open(&path);
        let abandoned = file.is_ok_and(|file| file.try_lock().is_ok());
        if abandoned {
            let _ = fs::remove_file(path);
        }
    }
}

/// Completes half renamed sets in the folder of a file that is to be read.
pub(crate) fn recover(folder: &Path) {
    if unfinished(folder).iter().any(|name| journal::is_one(name)) {
        let _held = hold(folder);
        complete(folder);
    }
}

/// The lock of a folder: who has it commits a set there, or mends one. None where a file system knows no locks.
pub(crate) fn hold(folder: &Path) -> Option<File> {
    let folder = File::open(folder).ok()?;
    folder.lock().ok()?;
    Some(folder)
}

/// Goes on with every set whose process ended while it gave the files their names. The caller holds the folder.
fn complete(folder: &Path) {
    for name in unfinished(folder).into_iter().filter(|name| journal::is_one(name)) {
        let path = folder.join(name);
        if let Some(journal) = Journal::read(&path) {
            journal.rename_all(folder);
        }
        let _ = fs::remove_file(path);
    }
}

fn unfinished(folder: &Path) -> Vec<String> {
    let Ok(entries) = fs::read_dir(folder) else { return Vec::new() };
    let names = entries.filter_map(|entry| entry.ok()?.file_name().into_string().ok());
    names.filter(|name| name.starts_with(UNFINISHED)).collect()
}
