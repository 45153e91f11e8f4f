//! Opens files for reading: ordinary files only. A pipe, a device or a folder is refused without waiting.

use std::fs::{File, FileType, OpenOptions};
use std::io::{ErrorKind, Read};
use std::path::Path;

use crate::budget::{Work, budget};
use crate::digest::Digest;
use crate::error::{Error, Result};
use crate::trace::observed;

/// Opens the ordinary file at `path` for reading.
///
/// # Errors
/// [`Error::Refused`] for a folder, pipe, socket or device; [`Error::Io`] if the file cannot be opened.
pub fn open(path: impl AsRef<Path>) -> Result<File> {
    let path = path.as_ref();
    observed(path, open_unobserved(path))
}

/// As [`open`], without a trace of it: for what this process writes.
pub(crate) fn open_unobserved(path: &Path) -> Result<File> {
    let unreadable = |e| Error::io(path, "read", e);
    // Opening a device may have effects, and a socket cannot be opened.
    refuse_special(path, path.metadata().map_err(unreadable)?.file_type())?;
    let file = without_waiting().open(path).map_err(unreadable)?;
    // Another file may have taken the name since.
    refuse_special(path, file.metadata().map_err(unreadable)?.file_type())?;
    Ok(file)
}

/// Whether there is something at `path` to [`open`], or to refuse.
pub fn exists(path: impl AsRef<Path>) -> bool {
    !matches!(open(path), Err(Error::Io { source, .. }) if source.kind() == ErrorKind::NotFound)
}

impl Digest {
    /// The digest of the file at `path`, read in one streaming pass.
    ///
    /// # Errors
    /// See [`open`]; [`Error::Io`] if the file cannot be read.
    pub fn of_file(path: impl AsRef<Path>) -> Result<Self> {
        let path = path.as_ref();
        Self::of_reader(open(path)?).map_err(|e| Error::io(path, "read", e))
    }

    /// As [`Digest::of_file`], without a trace of it: for what this process writes.
    pub(crate) fn of_own(path: &Path) -> Result<Self> {
        Self::of_reader(open_unobserved(path)?).map_err(|e| Error::io(path, "read", e))
    }
}

/// The bytes of the ordinary file at `path`.
///
/// # Errors
/// As [`open`]; [`Error::Refused`] if they do not fit in memory.
pub fn read(path: impl AsRef<Path>) -> Result<Vec<u8>> {
    let path = path.as_ref();
    bytes_of(path, open(path)?)
}

/// The contents of `file`, which was opened at `path`.
pub(crate) fn bytes_of(path: &Path, mut file: File) -> Result<Vec<u8>> {
    let unreadable = |e| Error::io(path, "read", e);
    let length = file.metadata().map_err(unreadable)?.len();
    let found = format!("{length} bytes");
    let work = Work { file: path, thing: "file", found: &found, remedy: REMEDY };
    budget().memory(work, length as f64)?;
    let mut bytes = Vec::new();
    let reserved = bytes.try_reserve_exact(usize::try_from(length).unwrap_or(usize::MAX));
    reserved.map_err(|_| unreadable(ErrorKind::OutOfMemory.into()))?;
    file.read_to_end(&mut bytes).map_err(unreadable)?;
    Ok(bytes)
}

/// The remedy for a file that is too large.
pub(crate) const REMEDY: &str = "name a smaller file, or raise --memory-mib";

/// Options that never wait: opening a pipe without a writer would block.
fn without_waiting() -> OpenOptions {
    let mut options = OpenOptions::new();
    options.read(true);
    #[cfg(unix)]
    {
        use rustix::fs::OFlags;
        use std::os::unix::fs::OpenOptionsExt;
        options.custom_flags((OFlags::NONBLOCK | OFlags::NOCTTY).bits() as i32);
    }
    options
}

fn refuse_special(path: &Path, kind: FileType) -> Result<()> {
    if kind.is_file() {
        return Ok(());
    }
    let remedy = "name a file: what comes from elsewhere has to be written into one first";
    Err(Error::refuse(path, "file", name_of(kind), "an ordinary file", remedy))
}

#[cfg(unix)]
fn name_of(kind: FileType) -> &'static str {
    use std::os::unix::fs::FileTypeExt;
    match kind {
        _ if kind.is_dir() => "a folder",
        _ if kind.is_fifo() => "a pipe",
        _ if kind.is_socket() => "a socket",
        _ => "a device",
    }
}

#[cfg(not(unix))]
fn name_of(kind: FileType) -> &'static str {
    if kind.is_dir() { "a folder" } else { "a device" }
}
