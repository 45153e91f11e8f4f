//! Giving a set of files their names, all or none.

use std::collections::BTreeSet;
use std::fs::{self, File};
use std::path::{Path, PathBuf};

use crate::digest::Digest;
use crate::document::{Document, stage_set_document};
use crate::error::{Error, Result};
use crate::fault;
use crate::hold::hold;
use crate::journal::Journal;
use crate::leftover::complete;
use crate::names::{UNFINISHED, folder_of};
use crate::provenance::Provenance;
use crate::staged::Staged;
use crate::unfinished;

/// Gives every file its name, replacing files of the same name. The first file is the main one: it gets its name last, so
/// that what waits for it (make) finds the whole set.
///
/// Sets of the same folder wait for each other. If a process ends between two renames, readers find what will have the names,
/// and the next to write in the folder of the main file completes the set. If a file cannot be renamed, those before it are what they were: that too is
/// completed by the next, should the process end meanwhile.
///
/// # Errors
/// [`Error::Refused`] if two files have the same target; [`Error::Io`] if one cannot be renamed, or another process holds the
/// folder.
pub fn commit(mut files: Vec<Staged>) -> Result<()> {
    refuse_same_targets(&files)?;
    let folders: BTreeSet<PathBuf> = files.iter().map(|file| folder_of(file.path()).to_owned()).collect();
    if files.len() < 2 {
        // Whoever is told to end meanwhile takes no file away that is just getting its name.
        let _committing = unfinished::committing();
        files.into_iter().try_for_each(Staged::rename)?;
    } else {
        let main = files.remove(0);
        files.push(main);
        commit_set(files)?;
    }
    folders.iter().for_each(|folder| flush(folder));
    Ok(())
}

/// Gives `table` its name, and `document` beside it the data that vouch for it.
///
/// # Errors
/// See [`stage_set_document`] and [`commit`].
pub fn commit_with_document<D: Document>(
    table: Staged,
    document: &Path,
    provenance: &Provenance,
    data: &D,
) -> Result<()> {
    let mut files = vec![table];
    files.push(stage_set_document(document, provenance, data, &files)?);
    commit(files)
}

/// Renames `files` in their order, the last of which is the main one.
fn commit_set(files: Vec<Staged>) -> Result<()> {
    let Some(main) = files.last().map(|main| main.path().to_owned()) else { return Ok(()) };
    let folder = folder_of(&main);
    // Whoever is told to end while the folder is waited for ends at once.
    let _held = hold(folder)?;
    let _committing = unfinished::committing();
    complete(folder);
    let journal = Journal::path(&main);
    let renames = files.iter().map(|file| Ok(([file.temporary(), file.path()], file.digest()?)));
    let renames: Vec<_> = renames.collect::<Result<_>>()?;
    let text = Journal::of(renames.into_iter(), folder).text(&journal)?;
    Staged::held_bytes(&journal, &text)?.rename()?;
    flush(folder);
    let mut replaced: Vec<Replaced> = Vec::new();
    for file in files {
        // A file that cannot be renamed stays until nobody counts on it.
        let (before, renamed) = match Replaced::keep(&file) {
            Ok(before) => (Some(before), file.try_rename()),
            Err(failure) => (None, Err(Box::new((file, failure)))),
        };
        match renamed {
            Ok(()) => replaced.extend(before),
            Err(failed) => {
                take_back(&journal, folder, replaced);
                return Err(failed.1);
            }
        }
    }
    let _ = fault::point("forget");
    let _ = fs::remove_file(journal);
    Ok(())
}

/// Gives back what a set took that cannot be completed. The journal says so first, so that whoever comes by goes on with
/// that, should this process end meanwhile.
fn take_back(journal: &Path, folder: &Path, replaced: Vec<Replaced>) {
    let back = replaced.iter().rev().filter_map(|one| {
        let renamed = one.back();
        Some((renamed, Digest::of_file(renamed[0]).ok()?))
    });
    let back = Journal::of(back, folder).text(journal);
    if back.and_then(|back| Staged::held_bytes(journal, &back)?.rename()).is_err() {
        // Nobody may go on with the set.
        let _ = fs::remove_file(journal);
    }
    flush(folder);
    replaced.into_iter().rev().for_each(Replaced::restore);
    let _ = fault::point("forget");
    let _ = fs::remove_file(journal);
}

/// What had a name before a set took it.
struct Replaced {
    target: PathBuf,
    /// What the set's file was called before.
    temporary: PathBuf,
    /// The file that had the name, under another; none where there was none.
    kept: Option<PathBuf>,
}

impl Replaced {
    fn keep(file: &Staged) -> Result<Self> {
        let target = file.path();
        let name = target.file_name().unwrap_or_default().to_string_lossy();
        let other = folder_of(target).join(format!("{UNFINISHED}old-{name}"));
        let _ = fs::remove_file(&other);
        let mut kept = Self { target: target.to_owned(), temporary: file.temporary().to_owned(), kept: None };
        if !target.symlink_metadata().is_ok_and(|found| found.is_file()) {
            return Ok(kept);
        }
        kept.kept = Some(other.clone());
        // A second name costs nothing; where the file system knows none, a copy does.
        let copied = |_| fs::copy(target, &other).map(drop);
        let done = fault::point("keep").and_then(|()| fs::hard_link(target, &other).or_else(copied));
        // What cannot be given back must not be taken.
        done.map(|()| kept).map_err(|e| Error::io(target, "replace", e))
    }

    /// The rename that gives the name back. A file that had none before gets that of an unfinished one, which goes.
    fn back(&self) -> [&Path; 2] {
        match &self.kept {
            Some(kept) => [kept, &self.target],
            None => [&self.target, &self.temporary],
        }
    }

    /// Gives the name back.
    fn restore(mut self) {
        let _ = fault::point("give back");
        // Nothing better can be done if this fails too; the first failure is reported.
        let _ = match self.kept.take() {
            Some(kept) => fs::rename(kept, &self.target),
            None => fs::remove_file(&self.target),
        };
    }
}

impl Drop for Replaced {
    fn drop(&mut self) {
        if let Some(kept) = self.kept.take() {
            let _ = fs::remove_file(kept);
        }
    }
}

fn refuse_same_targets(files: &[Staged]) -> Result<()> {
    for (i, file) in files.iter().enumerate() {
        if files[..i].iter().any(|other| other.path() == file.path()) {
            let (found, expected) = ("two files of this name", "one file per name");
            return Err(Error::refuse(file.path(), "output", found, expected, "name another output"));
        }
    }
    Ok(())
}

/// Flushes the new name to the disk where the system knows how; elsewhere the name may be lost in
/// a power cut, but never half a file.
fn flush(folder: &Path) {
    let _ = fault::point("flush the folder");
    if let Ok(folder) = File::open(folder) {
        let _ = folder.sync_all();
    }
}
