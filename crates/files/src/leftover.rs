//! What processes leave in a folder when they end early: files without names, half renamed sets.
//!
//! Readers only read: in a folder with a half renamed set they find the new files ([`open_written`]). Writers
//! in the folder complete the set and clean up.

use std::fs::{self, File, OpenOptions};
use std::io::ErrorKind;
use std::path::Path;

use crate::digest::Digest;
use crate::error::{Error, Result};
use crate::hold::{hold, try_hold};
use crate::journal::{self, Journal, Meaning};
use crate::names::{folder_of, is_own, unfinished_in};
use crate::ordinary::{bytes_of, open_itself, open_unobserved};
use crate::trace::observed;

/// What interrupted runs left in a folder.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Leftovers {
    /// Files that no run has finished.
    pub files: usize,
    /// Whether a set of files is half renamed.
    pub half_named: bool,
    /// Files that are named like journals but were not written as such: they are ignored and not removed.
    pub strange: Vec<String>,
}

impl Leftovers {
    /// The leftovers in `folder`, which contains `names`.
    pub fn of(folder: &Path, names: impl IntoIterator<Item = String>) -> Self {
        let (journals, others): (Vec<String>, Vec<String>) =
            names.into_iter().partition(|name| journal::is_one(name));
        let half_named = |name: &String| is_own(name) && Journal::read(&folder.join(name)).is_some();
        let (own, strange): (Vec<String>, Vec<String>) = journals.into_iter().partition(half_named);
        let files = others.iter().filter(|name| is_own(name)).count();
        Self { files: files + own.len(), half_named: !own.is_empty(), strange }
    }
}

/// Opens a file that a stage wrote, like [`open`]. If a process ended while it renamed a set, this is the
/// file that will have the name.
///
/// # Errors
/// See [`open`].
pub fn open_written(path: impl AsRef<Path>) -> Result<File> {
    let path = path.as_ref();
    let opened = match meaning(path) {
        None => open_unobserved(path),
        Some(Meaning::File(file)) => Ok(file),
        Some(Meaning::Nothing) => Err(Error::io(path, "read", ErrorKind::NotFound.into())),
    };
    observed(path, opened)
}

/// The meaning of `path` by a journal in its folder, or in the parent folder, if files in the folder await
/// their names.
fn meaning(path: &Path) -> Option<Meaning> {
    let (folder, name) = (folder_of(path), path.file_name()?.to_str()?);
    if unfinished_in(folder).is_empty() {
        return None;
    }
    let by = |folder: &Path, name: &str| {
        Journal::all(folder).iter().find_map(|(_, journal)| journal.meaning(folder, name))
    };
    let above = || by(folder_of(folder), &format!("{}/{name}", folder.file_name()?.to_str()?));
    by(folder, name).or_else(above)
}

/// The bytes of a file that [`open_written`] opens.
///
/// # Errors
/// See [`open_written`] and [`crate::read`].
pub fn read_written(path: impl AsRef<Path>) -> Result<Vec<u8>> {
    let path = path.as_ref();
    bytes_of(path, open_written(path)?)
}

impl Digest {
    /// The digest of the file that a stage wrote at `path`: see [`open_written`].
    ///
    /// # Errors
    /// As [`Digest::of_file`].
    pub fn of_written(path: impl AsRef<Path>) -> Result<Self> {
        let path = path.as_ref();
        Self::of_reader(open_written(path)?).map_err(|e| Error::io(path, "read", e))
    }
}

/// Whether [`open_written`] finds something at `path`.
pub fn is_written(path: impl AsRef<Path>) -> bool {
    match open_written(path) {
        Ok(_) => true,
        Err(Error::Io { source, .. }) => source.kind() != ErrorKind::NotFound,
        Err(Error::Refused { .. }) => true,
    }
}

/// Completes half renamed sets in `folder` and removes the unfinished files of processes that have ended. A
/// folder that cannot be repaired stays unchanged.
///
/// # Errors
/// [`Error::Io`] if there is a half renamed set and another process holds the folder.
pub(crate) fn sweep(folder: &Path) -> Result<()> {
    if unfinished_in(folder).is_empty() {
        return Ok(());
    }
    let held = if Journal::all(folder).is_empty() { try_hold(folder) } else { hold(folder)? };
    if held.is_none() {
        return Ok(());
    }
    complete(folder);
    for name in unfinished_in(folder).into_iter().filter(|name| !journal::is_one(name)) {
        let path = folder.join(name);
        if is_abandoned(&path) {
            let _ = fs::remove_file(path);
        } else if path.symlink_metadata().is_ok_and(|found| found.is_dir()) && try_hold(&path).is_some() {
            let _ = fs::remove_dir_all(path);
        }
    }
    Ok(())
}

/// Continues every set whose process ended during the renames. The caller holds the folder.
pub(crate) fn complete(folder: &Path) {
    for (name, journal) in Journal::all(folder) {
        journal.rename_all(folder);
        let _ = fs::remove_file(folder.join(name));
    }
}

/// The writer of a file holds its lock; without locks, the file stays.
fn is_abandoned(path: &Path) -> bool {
    // A link or a pipe of this name was not written here.
    open_itself(path).is_ok()
        && OpenOptions::new().read(true).write(true).open(path).is_ok_and(|file| file.try_lock().is_ok())
}
