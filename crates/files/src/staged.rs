//! Files that are complete but do not have their names yet: written as a whole or not at all.

use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use tempfile::{Builder, NamedTempFile, TempPath};

use crate::digest::Digest;
use crate::error::{Error, Result};
use crate::fault;
use crate::names::folder_of;
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
}

impl Staged {
    /// The path that the file will have.
    pub fn path(&self) -> &Path {
        &self.target
    }

    /// The digest of the complete file, which is read for that.
    ///
    /// # Errors
    /// [`Error::Io`] if it cannot be read.
    pub(crate) fn digest(&self) -> Result<Digest> {
        match self.digest.get() {
            Some(digest) => Ok(*digest),
            None => Digest::of_own(&self.temporary).map(|digest| *self.digest.get_or_init(|| digest)),
        }
    }

    /// Stages `bytes` as they are, for files of other formats (HTML, SVG, GPX).
    ///
    /// # Errors
    /// [`Error::Io`] if the file cannot be created or written; [`Error::Refused`] for a target that is not a
    /// file.
    pub fn bytes(path: impl AsRef<Path>, bytes: &[u8]) -> Result<Self> {
        let path = path.as_ref();
        let file = create_temporary(path)?;
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
        Ok(Self { temporary: file.into_temp_path(), target: target.to_owned(), digest: OnceLock::new() })
    }

    /// Gives the file its name, replacing the file that has it.
    pub(crate) fn rename(self) -> Result<()> {
        let Self { temporary, target, .. } = self;
        let renamed = fault::point("rename").and_then(|()| temporary.persist(&target).map_err(|e| e.error));
        renamed.map_err(|e| Error::io(target, "rename", e))
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
    refuse_special(target)?;
    check_within(target)?;
    let make = |builder: &Builder| fault::point("create").and_then(|()| builder.tempfile_in(folder));
    // The error's own text names the temporary file, which is of no use to the user: keep its kind only.
    unfinished::create(folder, 0o666, make).map_err(|e| Error::io(target, "create", e.kind().into()))
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
