//! Files that are complete but do not have their names yet: written as a whole or not at all.

use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Component, Path, PathBuf};
use std::sync::OnceLock;

use tempfile::{Builder, NamedTempFile, TempPath};

use crate::access::check_within;
use crate::error::{Error, Result};
use crate::seal::Digest;
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

/// Makes the folder `target`, with the folders `within` it: `write` fills a hidden folder beside it, whose path it gets, and
/// which then gets the name.
///
/// # Errors
/// [`Error::Io`] if the folder cannot be made or named; those of `write`.
pub fn whole_folder<E: From<Error>>(
    target: &Path,
    within: &[&str],
    write: impl FnOnce(&Path) -> Result<(), E>,
) -> Result<(), E> {
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

/// Flushes the new name to the disk where the system knows how; elsewhere the name may be lost in
/// a power cut, but never half a file.
pub(crate) fn flush(folder: &Path) {
    let _ = fault::point("flush the folder");
    if let Ok(folder) = File::open(folder) {
        let _ = folder.sync_all();
    }
}

/// Fault injection: a place where a test makes writing fail, or the process end. A release build has none.
pub mod fault {
    use std::io;

    /// The effect at a place.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub enum Fault {
        /// The system refuses.
        Error,
        /// The process is killed.
        Kill,
    }

    #[cfg(debug_assertions)]
    static NEXT: std::sync::Mutex<Option<(Fault, u32)>> = std::sync::Mutex::new(None);

    /// Triggers `fault` when the process reaches its `count`-th place, counted from 1. Only in builds with debug assertions.
    pub fn inject(fault: Fault, count: u32) {
        #[cfg(debug_assertions)]
        if let Ok(mut next) = NEXT.lock() {
            *next = Some((fault, count));
        }
        #[cfg(not(debug_assertions))]
        let _ = (fault, count);
    }

    /// A place: `create`, `write`, `put aside`, `seal`, `flush`, `rename`.
    #[cfg(debug_assertions)]
    pub(crate) fn point(name: &str) -> io::Result<()> {
        let Ok(mut next) = NEXT.lock() else { return Ok(()) };
        let Some((_, left)) = next.as_mut() else { return Ok(()) };
        *left = left.saturating_sub(1);
        if *left > 0 {
            return Ok(());
        }
        match next.take() {
            Some((Fault::Kill, _)) => std::process::abort(),
            _ => Err(io::Error::other(format!("a fault put there by a test ({name})"))),
        }
    }

    #[cfg(not(debug_assertions))]
    #[inline(always)]
    pub(crate) fn point(_: &str) -> io::Result<()> {
        Ok(())
    }
}

// Names and folders of files.

/// The folder of `file`.
pub(crate) fn folder_of(file: &Path) -> &Path {
    match file.parent() {
        Some(folder) if folder != Path::new("") => folder,
        _ => Path::new("."),
    }
}

/// Whether a relative path stays below its start.
pub(crate) fn is_inside(path: &Path) -> bool {
    path.components().all(|part| matches!(part, Component::Normal(_)))
}
