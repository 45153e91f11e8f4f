//! Files that are complete but do not have their names yet: written as a whole or not at all.

use std::fs::{File, Permissions, TryLockError};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use tempfile::{Builder, NamedTempFile, TempPath};

use crate::digest::Digest;
use crate::error::{Error, Result};
use crate::fault;
use crate::leftover;
use crate::names::{OWN, UNFINISHED, folder_of};
use crate::trace::check_within;
use crate::unfinished;

/// A complete file beside its target, under a temporary name and flushed to the disk.
///
/// [`crate::commit`] gives it its name; dropped without that, it disappears.
#[derive(Debug)]
pub struct Staged {
    temporary: TempPath,
    target: PathBuf,
    digest: OnceLock<Digest>,
    /// The lock that shows that this file's process is alive.
    _held: File,
}

impl Staged {
    /// The path that the file will have.
    pub fn path(&self) -> &Path {
        &self.target
    }

    /// The path of the complete file until it is committed.
    pub fn temporary(&self) -> &Path {
        &self.temporary
    }

    /// The digest of the complete file, which is read for that.
    ///
    /// # Errors
    /// [`Error::Io`] if it cannot be read.
    pub(crate) fn digest(&self) -> Result<Digest> {
        match self.digest.get() {
            Some(digest) => Ok(*digest),
            None => Digest::of_file(&self.temporary).map(|digest| *self.digest.get_or_init(|| digest)),
        }
    }

    /// Stages `bytes` as they are, for files of other formats (HTML, SVG, GPX).
    ///
    /// # Errors
    /// [`Error::Io`] if the file cannot be created or written; [`Error::Refused`] for a target that is not a
    /// file.
    pub fn bytes(path: impl AsRef<Path>, bytes: &[u8]) -> Result<Self> {
        let path = path.as_ref();
        Self::written(create_temporary(path)?, path, bytes)
    }

    /// As [`Staged::bytes`], for the holder of the folder of `path`.
    pub(crate) fn held_bytes(path: &Path, bytes: &[u8]) -> Result<Self> {
        Self::written(create_held(path)?, path, bytes)
    }

    fn written(file: NamedTempFile, path: &Path, bytes: &[u8]) -> Result<Self> {
        // Written through the file itself: errors of the temporary file name that file, which is of no use to
        // the user.
        let written = fault::point("write").and_then(|()| file.as_file().write_all(bytes));
        written.map_err(|e| Error::io(path, "write", e))?;
        Self::complete(file, path)
    }

    /// Flushes a temporary file to the disk.
    pub(crate) fn complete(file: NamedTempFile, target: &Path) -> Result<Self> {
        let flushed = fault::point("flush").and_then(|()| file.as_file().sync_all());
        flushed.map_err(|e| Error::io(target, "write", e))?;
        let (held, temporary) = file.into_parts();
        Ok(Self { temporary, target: target.to_owned(), digest: OnceLock::new(), _held: held })
    }

    /// Gives the file its name, replacing the file that has it.
    pub(crate) fn rename(self) -> Result<()> {
        self.try_rename().map_err(|failed| failed.1)
    }

    /// As [`Staged::rename`]. On failure the file stays until it is dropped, since a journal may refer to it.
    pub(crate) fn try_rename(self) -> std::result::Result<(), Box<(Self, Error)>> {
        let Self { temporary, target, digest, _held } = self;
        let failed = |temporary, target: PathBuf, error| {
            let error = Error::io(&target, "rename", error);
            Err(Box::new((Self { temporary, target, digest, _held }, error)))
        };
        if let Err(error) = fault::point("rename") {
            return failed(temporary, target, error);
        }
        match temporary.persist(&target) {
            Ok(()) => Ok(()),
            Err(failure) => failed(failure.path, target, failure.error),
        }
    }
}

/// How often a new file may be taken for a leftover by another process.
const MOST_TAKEN: usize = 1000;

/// Creates an empty temporary file, open for reading and writing, in the folder of `target`. The first one in
/// a folder removes the leftovers of killed processes.
pub(crate) fn create_temporary(target: &Path) -> Result<NamedTempFile> {
    let folder = folder_of(target);
    if unfinished::is_first_in(folder) {
        leftover::sweep(folder)?;
    }
    create_held(target)
}

fn create_held(target: &Path) -> Result<NamedTempFile> {
    let folder = folder_of(target);
    let fail = |kind: io::ErrorKind, what: String| Error::io(target, "create", io::Error::new(kind, what));
    if target.file_name().is_none() || target.is_dir() {
        return Err(fail(io::ErrorKind::IsADirectory, "a folder".to_owned()));
    }
    if !folder.is_dir() {
        let what = format!("no folder `{}`", folder.display());
        return Err(fail(io::ErrorKind::NotFound, what));
    }
    refuse_special(target)?;
    check_within(target)?;
    let mut builder = Builder::new();
    builder.prefix(UNFINISHED).suffix(OWN);
    if let Some(permissions) = ordinary_permissions(0o666) {
        builder.permissions(permissions);
    }
    for _ in 0..MOST_TAKEN {
        // The error's own text names the temporary file, which is of no use to the user: keep its kind only.
        let create = || fault::point("create").and_then(|()| builder.tempfile_in(folder));
        let file = unfinished::noted(create).map_err(|e| Error::io(target, "create", e.kind().into()))?;
        match file.as_file().try_lock() {
            // Another process took it for a leftover before it was locked.
            Err(TryLockError::WouldBlock) => {}
            // It may even have removed it before it was locked here.
            Ok(()) if !file.path().exists() => {}
            // Where a file system has no locks, no file is taken for a leftover.
            Ok(()) | Err(TryLockError::Error(_)) => return Ok(file),
        }
    }
    Err(fail(io::ErrorKind::ResourceBusy, "a process that takes every new file away".to_owned()))
}

/// Refuses to replace anything but an ordinary file: a device, a pipe, a link.
fn refuse_special(target: &Path) -> Result<()> {
    let Ok(metadata) = target.symlink_metadata() else { return Ok(()) };
    if metadata.is_file() {
        return Ok(());
    }
    let (found, remedy) = match target.read_link() {
        Ok(to) => (format!("a link to {}", to.display()), "name the file itself, or remove the link"),
        Err(_) => ("a device or pipe".to_owned(), "name a file"),
    };
    Err(Error::refuse(target, "output", found, "an ordinary file, or none", remedy))
}

/// The permissions of a new file or folder by the user's umask, instead of a private temporary one's.
#[cfg(unix)]
pub(crate) fn ordinary_permissions(mode: u32) -> Option<Permissions> {
    Some(std::os::unix::fs::PermissionsExt::from_mode(mode))
}

#[cfg(not(unix))]
pub(crate) fn ordinary_permissions(_: u32) -> Option<Permissions> {
    None
}
