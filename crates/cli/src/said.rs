//! Output of programs.

use std::fmt::Display;
use std::io::{self, ErrorKind, Write};

use crate::failure::Failure;

/// A line on stdout.
///
/// # Errors
/// See [`printed`].
pub fn on_stdout(line: impl Display) -> Result<(), Failure> {
    printed(writeln!(io::stdout().lock(), "{line}"))
}

/// What became of something printed on stdout. A closed pipe has a reader that wants no more, which is no failure.
///
/// # Errors
/// A full disk or a device that takes nothing.
pub fn printed(done: io::Result<()>) -> Result<(), Failure> {
    match done.and_then(|()| io::stdout().flush()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => Err(Failure::Failed(format!(
            "stdout: write: found {error}, expected room for what is printed; print elsewhere (files of --out are written)"
        ))),
        _ => Ok(()),
    }
}

/// A line on stderr, which nothing depends on.
pub fn on_stderr(line: impl Display) {
    let _ = writeln!(io::stderr().lock(), "{line}");
}
