//! The lock of a folder: who has it commits a set there, or mends one. Anybody who may read the folder can take it, so it is
//! waited for only for a while.

use std::fs::{File, TryLockError};
use std::io::{self, ErrorKind};
use std::path::Path;
use std::sync::OnceLock;
use std::time::Duration;

use crate::error::{Error, Result};
use crate::ordinary::without_waiting;

/// How long a folder is waited for, and what is done after a second of that.
#[derive(Clone, Copy, Debug)]
pub struct Patience {
    /// When the wait is given up.
    pub most: Duration,
    /// Called once with the folder where it takes longer than a second.
    pub tell: fn(&Path),
}

/// A commit takes milliseconds: after a minute there is another reason.
const USUAL: Patience = Patience { most: Duration::from_secs(60), tell: |_| {} };
const TOLD_AFTER: Duration = Duration::from_secs(1);
const BETWEEN: Duration = Duration::from_millis(5);

static PATIENCE: OnceLock<Patience> = OnceLock::new();

/// Sets how long folders are waited for; the first word counts. Without it a minute, in silence.
pub fn set_patience(patience: Patience) {
    PATIENCE.get_or_init(|| patience);
}

/// The lock of `folder`, as soon as no other process has it. None where a file system knows no locks.
///
/// # Errors
/// [`Error::Io`] if another process still holds it after a while.
pub(crate) fn hold(folder: &Path) -> Result<Option<File>> {
    let patience = PATIENCE.get_or_init(|| USUAL);
    let Ok(file) = without_waiting().open(folder) else { return Ok(None) };
    let mut waited = Duration::ZERO;
    loop {
        match file.try_lock() {
            Ok(()) => return Ok(Some(file)),
            Err(TryLockError::Error(_)) => return Ok(None),
            Err(TryLockError::WouldBlock) if waited >= patience.most => {
                let found =
                    format!("another process that has held its lock for {} s", patience.most.as_secs());
                return Err(Error::io(folder, "lock", io::Error::new(ErrorKind::TimedOut, found)));
            }
            Err(TryLockError::WouldBlock) => std::thread::sleep(BETWEEN),
        }
        if waited < TOLD_AFTER && waited + BETWEEN >= TOLD_AFTER {
            (patience.tell)(folder);
        }
        waited += BETWEEN;
    }
}

/// The lock of `folder`, if no other process has it and there is one.
pub(crate) fn try_hold(folder: &Path) -> Option<File> {
    without_waiting().open(folder).ok().filter(|file| file.try_lock().is_ok())
}
