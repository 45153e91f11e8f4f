//! Builds libraries with this machine's C compiler, if there is one.

use std::fs;
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::sync::{Mutex, MutexGuard, PoisonError};

use tempfile::TempDir;

use crate::failure::Failure;

/// The library that `compiler` builds from the sources `files` (name and text) with `flags`; `None` if there is no
/// such program. It works in a private folder whose name leaves no trace in the output.
pub fn compiled(
    compiler: &str,
    flags: &[&str],
    files: &[(String, String)],
) -> Result<Option<Vec<u8>>, Failure> {
    let failed = |what: String| Failure::Failed(format!("{compiler}: {what}"));
    let work = Work::begin().map_err(|e| failed(format!("temporary folder: {e}")))?;
    let folder = work.folder.path();
    let io = |e: io::Error| files::Error::io(folder, "use", e);
    for (name, text) in files {
        fs::write(folder.join(name), text).map_err(io)?;
    }
    let sources = files
        .iter()
        .map(|(name, _)| name)
        .filter(|name| Path::new(name).extension().is_some_and(|e| e == "c"));
    let mut command = Command::new(compiler);
    command.args(flags).args(sources).args(["-o", "library", "-lm"]).current_dir(folder);
    // The compiler's temporary files are removed with the folder.
    command.env("TMPDIR", folder);
    let output = match work.output(command) {
        Ok(output) => output,
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(None),
        Err(error) => return Err(failed(error.to_string())),
    };
    if !output.status.success() {
        let said = String::from_utf8_lossy(&output.stderr);
        let first = said.lines().find(|line| line.contains("error")).unwrap_or("no word of why").trim();
        return Err(failed(format!(
            "found that it does not compile the unit ({first}), expected a C99 compiler; name another with CC="
        )));
    }
    Ok(Some(fs::read(folder.join("library")).map_err(io)?))
}

/// Work in progress, for signals that end the process.
static UNDER_WAY: Mutex<Vec<UnderWay>> = Mutex::new(Vec::new());

struct UnderWay {
    folder: PathBuf,
    /// The compiler and what it has started.
    group: Option<u32>,
}

/// Ends the compilers of this process and removes their folders; the process must end after that.
pub(crate) fn abandon() {
    let under_way = under_way();
    for work in &*under_way {
        work.group.into_iter().for_each(end);
        // A process that is ending may still write a file.
        for _ in 0..50 {
            if fs::remove_dir_all(&work.folder).is_ok() || !work.folder.exists() {
                break;
            }
            std::thread::sleep(std::time::Duration::from_millis(10));
        }
    }
    // Keeps the lock, so that no work starts or ends any more.
    std::mem::forget(under_way);
}

/// A folder to compile in, registered while it exists.
struct Work {
    folder: TempDir,
}

impl Work {
    fn begin() -> io::Result<Self> {
        let mut under_way = under_way();
        let folder = private_folder()?;
        under_way.push(UnderWay { folder: folder.path().to_owned(), group: None });
        Ok(Self { folder })
    }

    /// The output of `command`.
    fn output(&self, mut command: Command) -> io::Result<Output> {
        command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
        apart(&mut command);
        let child = self.noted(|| command.spawn())?;
        child.wait_with_output()
    }

    /// Registers the child that `spawn` starts; no signal is handled in between.
    fn noted(&self, spawn: impl FnOnce() -> io::Result<Child>) -> io::Result<Child> {
        let mut under_way = under_way();
        let child = spawn()?;
        let work = under_way.iter_mut().find(|work| work.folder == self.folder.path());
        work.into_iter().for_each(|work| work.group = Some(child.id()));
        Ok(child)
    }
}

impl Drop for Work {
    fn drop(&mut self) {
        under_way().retain(|work| work.folder != self.folder.path());
    }
}

fn under_way() -> MutexGuard<'static, Vec<UnderWay>> {
    UNDER_WAY.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(unix)]
fn private_folder() -> io::Result<TempDir> {
    use std::os::unix::fs::PermissionsExt;
    tempfile::Builder::new().permissions(fs::Permissions::from_mode(0o700)).tempdir()
}

#[cfg(not(unix))]
fn private_folder() -> io::Result<TempDir> {
    tempfile::tempdir()
}

/// Starts `command` in its own process group, which can be ended as a whole.
#[cfg(unix)]
fn apart(command: &mut Command) {
    std::os::unix::process::CommandExt::process_group(command, 0);
}

#[cfg(not(unix))]
fn apart(_: &mut Command) {}

#[cfg(unix)]
fn end(group: u32) {
    use rustix::process::{Pid, Signal, kill_process_group};
    if let Some(pid) = i32::try_from(group).ok().and_then(Pid::from_raw) {
        // The group may have ended already.
        let _ = kill_process_group(pid, Signal::KILL);
    }
}

#[cfg(not(unix))]
fn end(_: u32) {}
