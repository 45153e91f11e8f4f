//! Folders that appear whole or not at all.

use std::fs;
use std::path::Path;

use tempfile::Builder;

use crate::commit::flush;
use crate::error::{Error, Result};
use crate::hold::try_hold;
use crate::leftover::sweep;
use crate::names::{OWN, UNFINISHED, folder_of};
use crate::staged::ordinary_permissions;
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
    let named = || -> Result<_> {
        sweep(parent)?;
        let mut builder = Builder::new();
        builder.prefix(UNFINISHED).suffix(OWN);
        if let Some(permissions) = ordinary_permissions(0o777) {
            builder.permissions(permissions);
        }
        let make = || {
            let made = builder.tempdir_in(parent)?;
            within.iter().try_for_each(|name| fs::create_dir(made.path().join(name)))?;
            Ok(made)
        };
        // The error's own text names the hidden folder, which is of no use to the user: keep its kind only.
        unfinished::noted(make).map_err(|e| Error::io(target, "create", e.kind().into()))
    };
    let made = named()?;
    let held = try_hold(made.path());
    write(made.path())?;
    let _committing = unfinished::committing();
    fs::rename(made.path(), target).map_err(|e| Error::io(target, "rename", e))?;
    drop((held, made.keep()));
    flush(parent);
    Ok(())
}
