//! Output of programs. A closed pipe or a full disk loses it, without any other effect.

use std::fmt::Display;
use std::io::{self, Write};

/// A line on stdout.
pub fn on_stdout(line: impl Display) {
    let _ = writeln!(io::stdout().lock(), "{line}");
}

/// A line on stderr.
pub fn on_stderr(line: impl Display) {
    let _ = writeln!(io::stderr().lock(), "{line}");
}
