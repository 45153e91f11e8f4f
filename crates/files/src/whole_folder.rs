//! Folders that appear whole or not at all.

use std::fs;
use std::path::Path;

use crate::commit::flush;
use crate::error::Error;
use crate::names::folder_of;
use crate::unfinished;

/// Makes the folder `target`, with the folders `within` it: `write` fills a hidden folder beside it, whose path it gets, and
/// which then gets the name.
///
/// # Errors
/// [`Error::Io`] if the folder cannot be made or named; those of `write`.
pub fn whole_folder<E: From<Error>>(
    target: &Path,
    within: &[&str],
    write: impl FnOnce(&Path) -> std::result::Result<(), E>,
) -> std::result::Result<(), E> {
    let parent = folder_of(target);
    let make = |builder: &tempfile::Builder| {
        let made = builder.tempdir_in(parent)?;
        within.iter().try_for_each(|name| fs::create_dir(made.path().join(name)))?;
        Ok(made)
    };
    // The error's own text names the hidden folder, which is of no use to the user: keep its kind only.
    let made = unfinished::create(parent, 0o777, make);
    let made = made.map_err(|e| Error::io(target, "create", e.kind().into()))?;
    write(made.path())?;
    let _held = unfinished::held();
    fs::rename(made.path(), target).map_err(|e| Error::io(target, "rename", e))?;
    drop(made.keep());
    flush(parent);
    Ok(())
}
