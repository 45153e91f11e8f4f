//! Gives the files of a set their names: the members first, the document that vouches for them last.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use crate::document::{Document, stage_set_document};
use crate::error::{Error, Result};
use crate::names::folder_of;
use crate::provenance::Provenance;
use crate::set;
use crate::staged::{Staged, flush};
use crate::trace::wrote;
use crate::unfinished;

/// Gives every file its name, in order, replacing files of the same name. The last one is the document that vouches for the
/// others, if there is one, and the one that tools wait for (make): what the document of this name vouched for before, and does
/// not now, is removed.
///
/// If a process ends between two renames, or one fails, the document refuses the files that are not its own. The stage is then to
/// be run again.
///
/// # Errors
/// [`Error::Refused`] if two files have the same target; [`Error::Io`] if one cannot be renamed.
pub fn commit(mut files: Vec<Staged>) -> Result<()> {
    refuse_same_targets(&files)?;
    let folders: BTreeSet<PathBuf> = files.iter().map(|file| folder_of(file.path()).to_owned()).collect();
    files.iter().for_each(|file| wrote(file.path()));
    let Some(last) = files.pop() else { return Ok(()) };
    let earlier = set::earlier(last.path(), &files);
    // No signal comes in between.
    let held = unfinished::held();
    files.into_iter().try_for_each(Staged::rename)?;
    earlier.iter().for_each(|file| drop(fs::remove_file(file)));
    last.rename()?;
    drop(held);
    folders.iter().for_each(|folder| flush(folder));
    Ok(())
}

/// Gives `member` its name, and its name to the document beside it, which contains `data` and vouches for it.
///
/// # Errors
/// See [`stage_set_document`] and [`commit`].
pub fn commit_with_document<D: Document>(
    member: Staged,
    document: &Path,
    provenance: &Provenance,
    data: &D,
) -> Result<()> {
    let mut files = vec![member];
    files.push(stage_set_document(document, provenance, data, &files)?);
    commit(files)
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
