//! The unfinished files of this process, for the case that it is told to end.

use std::collections::BTreeSet;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

use tempfile::NamedTempFile;

/// Files that were created here; some have got their names since, or are gone.
static CREATED: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());

/// Held while a set gets its names.
static COMMITTING: Mutex<()> = Mutex::new(());

/// Folders whose leftovers were removed.
static SWEPT: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());

/// Removes the unfinished files of this process, which must end after that. A set that is just getting its names gets them
/// all before.
pub fn abandon() {
    // The process ends with these locks held: nothing is created or named any more.
    std::mem::forget(committing());
    let created = lock(&CREATED);
    created.iter().for_each(|path| {
        // Most are gone: they have got their names.
        let _ = fs::remove_file(path);
    });
    std::mem::forget(created);
}

/// Notes the file that `create` creates, which is to be removed if the process is told to end: not between the two.
pub(crate) fn noted(create: impl FnOnce() -> io::Result<NamedTempFile>) -> io::Result<NamedTempFile> {
    let mut created = lock(&CREATED);
    let file = create()?;
    created.insert(file.path().to_owned());
    Ok(file)
}

/// A set is getting its names for as long as this is held.
pub(crate) fn committing() -> MutexGuard<'static, ()> {
    lock(&COMMITTING)
}

/// Whether this is the first file that the process creates in `folder`.
pub(crate) fn is_first_in(folder: &Path) -> bool {
    lock(&SWEPT).insert(folder.to_owned())
}

fn lock<T>(mutex: &'static Mutex<T>) -> MutexGuard<'static, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
