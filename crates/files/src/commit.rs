//! Renames a set of files atomically: all or none.

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
use crate::names::{OLD, SET, folder_of, marked};
use crate::provenance::Provenance;
use crate::staged::Staged;
use crate::trace::wrote;
use crate::unfinished;

/// Gives every file its name, replacing files of the same name. The first file is the main one: it gets its
/// name last, so that tools that wait for it (make) find the whole set.
///
/// Sets of the same folder wait for each other. If a process ends between two renames, readers find the new
/// files, and the next writer in the folder of the main file completes the set. If a file cannot be renamed,
/// the previous renames are reverted; the next writer completes that too, should the process end in the
/// meantime.
///
/// # Errors
/// [`Error::Refused`] if two files have the same target; [`Error::Io`] if one cannot be renamed, or another process holds the
/// folder.
pub fn commit(mut files: Vec<Staged>) -> Result<()> {
    refuse_same_targets(&files)?;
    let folders: BTreeSet<PathBuf> = files.iter().map(|file| folder_of(file.path()).to_owned()).collect();
    files.iter().for_each(|file| wrote(file.path()));
    if files.len() < 2 {
        // A signal during the renames never removes a file that is being renamed.
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

/// Gives `table` its name, and its name to the document beside it, which contains `data` and vouches for the
/// table.
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

/// Renames `files` in order, the main one last.
fn commit_set(files: Vec<Staged>) -> Result<()> {
    let Some((main, journal)) =
        files.last().map(|main| (main.path().to_owned(), marked(main.temporary(), SET)))
    else {
        return Ok(());
    };
    let folder = folder_of(&main);
    // A signal while waiting for the folder ends the process at once.
    let _held = hold(folder)?;
    let _committing = unfinished::committing();
    complete(folder);
    let renames = files.iter().map(|file| Ok(([file.temporary(), file.path()], file.digest()?)));
    let renames: Vec<_> = renames.collect::<Result<_>>()?;
    let text = Journal::of(renames.into_iter(), folder).text(&journal)?;
    Staged::held_bytes(&journal, &text)?.rename()?;
    flush(folder);
    let mut replaced: Vec<Replaced> = Vec::new();
    for file in files {
        // A file that cannot be renamed stays as long as the journal mentions it.
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

/// Reverts the renames of a set that cannot be completed. The journal records this first, so that the next
/// writer continues the reversal, should this process end in the meantime.
fn take_back(journal: &Path, folder: &Path, replaced: Vec<Replaced>) {
    let back = replaced.iter().rev().filter_map(|one| {
        let renamed = one.back();
        Some((renamed, Digest::of_file(renamed[0]).ok()?))
    });
    let back = Journal::of(back, folder).text(journal);
    if back.and_then(|back| Staged::held_bytes(journal, &back)?.rename()).is_err() {
        // Without a new journal, the set must not be completed.
        let _ = fs::remove_file(journal);
    }
    flush(folder);
    replaced.into_iter().rev().for_each(Replaced::restore);
    let _ = fault::point("forget");
    let _ = fs::remove_file(journal);
}

/// The previous owner of a name.
struct Replaced {
    target: PathBuf,
    /// The temporary name of the set's file.
    temporary: PathBuf,
    /// The previous file under another name, if there was one.
    kept: Option<PathBuf>,
}

impl Replaced {
    fn keep(file: &Staged) -> Result<Self> {
        let target = file.path();
        let other = marked(file.temporary(), OLD);
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
pub(crate) fn flush(folder: &Path) {
    let _ = fault::point("flush the folder");
    if let Ok(folder) = File::open(folder) {
        let _ = folder.sync_all();
    }
}
