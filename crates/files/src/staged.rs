//! Files that are complete but do not have their names yet: written as a whole or not at all.
//!
//! Names of unfinished files and folders say which process writes them: the next one that writes in the folder removes those of
//! processes that have ended, and a signal those of this process.

use std::collections::BTreeSet;
use std::fs::{self, File, Permissions};
use std::io::{self, Write};
use std::path::{Component, Path, PathBuf};
use std::sync::{Mutex, MutexGuard, OnceLock, PoisonError};
use std::time::Duration;

use tempfile::{Builder, NamedTempFile, TempPath};

use crate::access::{check_within, refuse_device};
use crate::error::{Error, Result};
use crate::seal::Digest;

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
    pub(crate) fn digest(&self) -> Result<Digest> {
        // No signal removes the file meanwhile.
        let _held = hold_names();
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
    refuse_device(target)?;
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
    create_unfinished(folder, 0o666, make).map_err(|e| Error::io(target, "create", e.kind().into()))
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
    let make = |builder: &Builder| {
        let made = builder.tempdir_in(parent)?;
        within.iter().try_for_each(|name| fs::create_dir(made.path().join(name)))?;
        Ok(made)
    };
    // The error's own text names the hidden folder, which is of no use to the user: keep its kind only.
    let made = create_unfinished(parent, 0o777, make);
    let made = made.map_err(|e| Error::io(target, "create", e.kind().into()))?;
    write(made.path())?;
    let _held = hold_names();
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

/// A name is `.unfinished-<machine>-<process>-<random>.seatrial`: files of a user have no such names by chance.
const BEFORE: &str = ".unfinished-";
const AFTER: &str = ".seatrial";
const RANDOM: usize = 6;

/// The machine where its id is not known.
const SOME_MACHINE: &str = "0";

/// How long nobody writes to what is left on another machine, of which it is not known whether its process lives.
const LEFT: Duration = Duration::from_secs(7 * 24 * 3600);

/// The folders in which this process has created files. Held while one is created and while a set is renamed, so that no signal
/// comes in between.
static FOLDERS: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());

/// Held while a set is renamed.
pub(crate) fn hold_names() -> MutexGuard<'static, BTreeSet<PathBuf>> {
    FOLDERS.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Removes the unfinished files of this process, which must end after that. A set that is being renamed is
/// completed first.
pub fn abandon() {
    let folders = hold_names();
    let (machine, process) = (machine(), std::process::id());
    let is_own = |of: (&str, u32), _: &Path| of == (machine.as_deref().unwrap_or(SOME_MACHINE), process);
    folders.iter().for_each(|folder| remove_unfinished(folder, is_own));
    // The process ends with this lock held, so that nothing is created or renamed any more.
    std::mem::forget(folders);
}

/// Creates an unfinished file or folder in `folder` by `make`, with the permissions `mode` and the user's umask. The first one in a
/// folder removes what processes left there that have ended.
fn create_unfinished<T: AsRef<Path>>(
    folder: &Path,
    mode: u32,
    make: impl FnOnce(&Builder) -> io::Result<T>,
) -> io::Result<T> {
    let mut folders = hold_names();
    let machine = machine();
    let name = format!("{BEFORE}{}-{}-", machine.as_deref().unwrap_or(SOME_MACHINE), std::process::id());
    let mut builder = Builder::new();
    builder.prefix(&name).suffix(AFTER).rand_bytes(RANDOM);
    if let Some(permissions) = ordinary_permissions(mode) {
        builder.permissions(permissions);
    }
    let made = make(&builder)?;
    if folders.insert(folder.to_owned()) {
        // By the clock of the folder, which may be on another machine.
        let now = modified_at(made.as_ref());
        let is_left = |(of, process): (&str, u32), path: &Path| {
            let age = || now?.duration_since(modified_at(path)?).ok();
            has_ended(process) && (machine.as_deref() == Some(of) || age().is_some_and(|age| age > LEFT))
        };
        remove_unfinished(folder, is_left);
    }
    Ok(made)
}

/// Whether `path` has the name of an unfinished file.
pub fn is_unfinished(path: &Path) -> bool {
    path.file_name().and_then(|name| name.to_str()).is_some_and(|name| writer_of(name).is_some())
}

/// The machine and the process that write the unfinished file `name`.
fn writer_of(name: &str) -> Option<(&str, u32)> {
    let (machine, rest) = name.strip_prefix(BEFORE)?.strip_suffix(AFTER)?.split_once('-')?;
    let (process, random) = rest.split_once('-')?;
    let is_random = random.len() == RANDOM && random.bytes().all(|byte| byte.is_ascii_alphanumeric());
    Some((machine, process.parse().ok()?)).filter(|_| is_random)
}

/// Removes the unfinished files and folders in `folder` of which `is_left` says so.
fn remove_unfinished(folder: &Path, is_left: impl Fn((&str, u32), &Path) -> bool) {
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        let (name, path) = (entry.file_name(), entry.path());
        if name.to_str().and_then(writer_of).is_some_and(|of| is_left(of, &path)) {
            let _ = fs::remove_file(&path).or_else(|_| fs::remove_dir_all(&path));
        }
    }
}

fn modified_at(path: &Path) -> Option<std::time::SystemTime> {
    path.symlink_metadata().ok()?.modified().ok()
}

/// This machine since its start, and the process ids that count here; `None` if that is not known.
fn machine() -> Option<String> {
    let start = fs::read("/proc/sys/kernel/random/boot_id").ok()?;
    let ids = fs::read_link("/proc/self/ns/pid").ok()?;
    let both = [&start, ids.as_os_str().as_encoded_bytes()].concat();
    Some(Digest::of_bytes(&both).hex()[..8].to_owned())
}

/// Whether no process has this id here.
#[cfg(unix)]
fn has_ended(process: u32) -> bool {
    use rustix::process::{Pid, test_kill_process};
    let id = i32::try_from(process).ok().and_then(Pid::from_raw);
    id.is_none_or(|id| test_kill_process(id) == Err(rustix::io::Errno::SRCH))
}

#[cfg(not(unix))]
fn has_ended(_: u32) -> bool {
    true
}

/// The permissions of a new file or folder by the user's umask, instead of a private temporary one's.
#[cfg(unix)]
fn ordinary_permissions(mode: u32) -> Option<Permissions> {
    Some(std::os::unix::fs::PermissionsExt::from_mode(mode))
}

#[cfg(not(unix))]
fn ordinary_permissions(_: u32) -> Option<Permissions> {
    None
}
