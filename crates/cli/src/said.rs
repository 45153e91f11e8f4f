//! What programs print. Who closed the pipe, or has no room left, misses it; nothing else changes by that.

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
