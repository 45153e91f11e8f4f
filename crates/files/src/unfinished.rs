//! The unfinished files and folders of this process, to be removed on a signal.

use std::collections::BTreeSet;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// What was created here; some have got their names since, or were removed.
static CREATED: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());

/// Held while a set is renamed.
static COMMITTING: Mutex<()> = Mutex::new(());

/// Folders whose leftovers were removed.
static SWEPT: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());

/// Removes the unfinished files of this process, which must end after that. A set that is being renamed is
/// completed first.
pub fn abandon() {
    // The process ends with these locks held, so that nothing is created or renamed any more.
    std::mem::forget(committing());
    let created = lock(&CREATED);
    created.iter().for_each(|path| {
        // Most of them have got their names, and no longer exist under these.
        let _ = fs::remove_file(path).or_else(|_| fs::remove_dir_all(path));
    });
    std::mem::forget(created);
}

/// Records the file or folder that `create` creates, to be removed on a signal: a signal cannot come between the two.
pub(crate) fn noted<T: AsRef<Path>>(create: impl FnOnce() -> io::Result<T>) -> io::Result<T> {
    let mut created = lock(&CREATED);
    let made = create()?;
    created.insert(made.as_ref().to_owned());
    Ok(made)
}

/// Held while a set is renamed.
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
