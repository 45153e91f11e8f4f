//! The lock of a folder: its owner commits or completes a set there. Anyone who may read the folder can take
//! it, so waiting for it is limited.

use std::fs::{File, TryLockError};
use std::io::{self, ErrorKind};
use std::path::Path;
use std::sync::OnceLock;
use std::time::Duration;

use crate::error::{Error, Result};
use crate::ordinary::without_waiting;

/// How long to wait for a folder, and the action after a second.
#[derive(Clone, Copy, Debug)]
pub struct Patience {
    /// When to give up.
    pub most: Duration,
    /// Called once with the folder if it takes longer than a second.
    pub notify: fn(&Path),
}

/// A commit takes milliseconds: after a minute there must be another reason.
const USUAL: Patience = Patience { most: Duration::from_secs(60), notify: |_| {} };
const NOTIFY_AFTER: Duration = Duration::from_secs(1);
const BETWEEN: Duration = Duration::from_millis(5);

static PATIENCE: OnceLock<Patience> = OnceLock::new();

/// Sets the patience of this process; only the first call counts. By default a minute, without notice.
pub fn set_patience(patience: Patience) {
    PATIENCE.get_or_init(|| patience);
}

/// Waits for the lock of `folder`. `None` where a file system has no locks.
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
        if waited < NOTIFY_AFTER && waited + BETWEEN >= NOTIFY_AFTER {
            (patience.notify)(folder);
        }
        waited += BETWEEN;
    }
}

/// The lock of `folder`, if it is free and there is one.
pub(crate) fn try_hold(folder: &Path) -> Option<File> {
    without_waiting().open(folder).ok().filter(|file| file.try_lock().is_ok())
}
