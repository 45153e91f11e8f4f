//! Unfinished files and folders. Their names say which process writes them: the next one that writes in the folder removes those of
//! processes that have ended, and a signal those of this process.

use std::collections::BTreeSet;
use std::fs::{self, Permissions};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use tempfile::Builder;

use crate::seal::Digest;

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
pub(crate) fn held() -> MutexGuard<'static, BTreeSet<PathBuf>> {
    FOLDERS.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Removes the unfinished files of this process, which must end after that. A set that is being renamed is
/// completed first.
pub fn abandon() {
    let folders = held();
    let (machine, process) = (machine(), std::process::id());
    let is_own = |of: (&str, u32), _: &Path| of == (machine.as_deref().unwrap_or(SOME_MACHINE), process);
    folders.iter().for_each(|folder| remove_unfinished(folder, is_own));
    // The process ends with this lock held, so that nothing is created or renamed any more.
    std::mem::forget(folders);
}

/// Creates an unfinished file or folder in `folder` by `make`, with the permissions `mode` and the user's umask. The first one in a
/// folder removes what processes left there that have ended.
pub(crate) fn create<T: AsRef<Path>>(
    folder: &Path,
    mode: u32,
    make: impl FnOnce(&Builder) -> io::Result<T>,
) -> io::Result<T> {
    let mut folders = held();
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
        let now = changed(made.as_ref());
        let is_left = |(of, process): (&str, u32), path: &Path| {
            let age = || now?.duration_since(changed(path)?).ok();
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

fn changed(path: &Path) -> Option<std::time::SystemTime> {
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
