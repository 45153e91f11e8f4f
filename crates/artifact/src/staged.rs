//! Files that are complete but not yet under their names: written whole or not at all.

use std::fs::{File, Permissions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use tempfile::{Builder, NamedTempFile, TempPath};

use crate::error::{Error, Result};

/// A complete file beside its target, under a temporary name and flushed to the disk.
///
/// [`commit`] gives it its name; dropped without that, it disappears.
#[derive(Debug)]
pub struct Staged {
    temporary: TempPath,
    target: PathBuf,
}

impl Staged {
    /// The path that the file will have.
    pub fn path(&self) -> &Path {
        &self.target
    }

    /// Where the complete file stands until it is committed.
    pub fn temporary(&self) -> &Path {
        &self.temporary
    }

    /// Stages `bytes` as they are, for files of other formats (HTML, SVG, GPX).
    ///
    /// # Errors
    /// [`Error::Io`] if the file cannot be created or written.
    pub fn bytes(path: impl AsRef<Path>, bytes: &[u8]) -> Result<Self> {
        let path = path.as_ref();
        let file = create_temporary(path)?;
        // Through the file itself: the temporary file's own errors name it, which tells the user nothing.
        file.as_file().write_all(bytes).map_err(|e| Error::io(path, "write", e))?;
        Self::complete(file, path)
    }

    /// Flushes a temporary file to the disk and closes it.
    pub(crate) fn complete(file: NamedTempFile, target: &Path) -> Result<Self> {
        file.as_file().sync_all().map_err(|e| Error::io(target, "write", e))?;
        Ok(Self { temporary: file.into_temp_path(), target: target.to_owned() })
    }
}

/// Creates an empty temporary file, open for reading and writing, in the folder of `target`.
pub(crate) fn create_temporary(target: &Path) -> Result<NamedTempFile> {
    let folder = folder_of(target);
    let fail = |kind: io::ErrorKind, what: String| Error::io(target, "create", io::Error::new(kind, what));
    if target.file_name().is_none() || target.is_dir() {
        return Err(fail(io::ErrorKind::IsADirectory, "a folder".to_owned()));
    }
    if !folder.is_dir() {
        let what = format!("no folder `{}`", folder.display());
        return Err(fail(io::ErrorKind::NotFound, what));
    }
    let mut builder = Builder::new();
    builder.prefix(".unfinished-");
    if let Some(permissions) = ordinary_permissions() {
        builder.permissions(permissions);
    }
    // The error's own text names the temporary file, which tells the user nothing: keep its kind.
    builder.tempfile_in(folder).map_err(|e| Error::io(target, "create", e.kind().into()))
}

fn folder_of(target: &Path) -> &Path {
    match target.parent() {
        Some(folder) if folder != Path::new("") => folder,
        _ => Path::new("."),
    }
}

/// What the user's umask makes of a new file, instead of a private temporary file's permissions.
#[cfg(unix)]
fn ordinary_permissions() -> Option<Permissions> {
    Some(std::os::unix::fs::PermissionsExt::from_mode(0o666))
}

#[cfg(not(unix))]
fn ordinary_permissions() -> Option<Permissions> {
    None
}

/// Gives every file its name, replacing files of the same name.
///
/// If one cannot be renamed, those already renamed are removed again, so that nothing of this
/// set stands under its name.
///
/// # Errors
/// [`Error::Refused`] if two files have the same target; [`Error::Io`] if one cannot be renamed.
pub fn commit(files: Vec<Staged>) -> Result<()> {
    refuse_same_targets(&files)?;
    let mut done: Vec<PathBuf> = Vec::new();
    for Staged { temporary, target } in files {
        if let Err(failure) = temporary.persist(&target) {
            for renamed in done {
                // Nothing better can be done if this fails too; the first failure is reported.
                let _ = std::fs::remove_file(renamed);
            }
            return Err(Error::io(target, "rename", failure.error));
        }
        done.push(target);
    }
    done.iter().for_each(|target| flush_folder(folder_of(target)));
    Ok(())
}

fn refuse_same_targets(files: &[Staged]) -> Result<()> {
    for (i, file) in files.iter().enumerate() {
        if files[..i].iter().any(|other| other.target == file.target) {
            let (found, expected) = ("two files of this name", "one file per name");
            return Err(Error::refuse(&file.target, "output", found, expected, "name another output"));
        }
    }
    Ok(())
}

/// Flushes the new name to the disk where the system knows how; elsewhere the name may be lost in
/// a power cut, but never half a file.
fn flush_folder(folder: &Path) {
    if let Ok(folder) = File::open(folder) {
        let _ = folder.sync_all();
    }
}
