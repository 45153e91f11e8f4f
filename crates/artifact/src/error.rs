//! What can go wrong, told in one line.

use std::fmt;
use std::io;
use std::path::PathBuf;

/// Result of this crate's functions.
pub type Result<T> = std::result::Result<T, Error>;

/// Bad input, or failed input and output.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The contents of a file, or what was to be written, are not acceptable.
    #[error("{0}")]
    Refused(Refusal),
    /// The operating system refused to read or write.
    #[error("{}", io_line(.path, .action, .source))]
    Io {
        /// The file or folder.
        path: PathBuf,
        /// What was being done to it: `read`, `write`, `create`, `rename`.
        action: &'static str,
        /// The operating system's answer.
        source: io::Error,
    },
}

/// Why an input is not acceptable, and what to do about it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Refusal {
    /// The file that holds the thing; for a block not yet in a file, the table's schema id.
    pub file: PathBuf,
    /// The thing that is wrong: a key, a column, a row, the seal.
    pub thing: String,
    /// What is there.
    pub found: String,
    /// What should be there.
    pub expected: String,
    /// What the user can do.
    pub remedy: String,
}

impl Error {
    /// An [`Error::Refused`] from its parts.
    pub fn refuse(
        file: impl Into<PathBuf>,
        thing: impl Into<String>,
        found: impl Into<String>,
        expected: impl Into<String>,
        remedy: impl Into<String>,
    ) -> Self {
        Self::Refused(Refusal {
            file: file.into(),
            thing: thing.into(),
            found: found.into(),
            expected: expected.into(),
            remedy: remedy.into(),
        })
    }

    /// An [`Error::Io`] from its parts.
    pub fn io(path: impl Into<PathBuf>, action: &'static str, source: io::Error) -> Self {
        Self::Io { path: path.into(), action, source }
    }
}

impl fmt::Display for Refusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let file = self.file.display();
        let Self { thing, found, expected, remedy, .. } = self;
        let line = format!("{file}: {thing}: found {found}, expected {expected}; {remedy}");
        f.write_str(&one_line(&line))
    }
}

/// `text` with every run of line breaks and other control characters replaced by one space.
fn one_line(text: &str) -> String {
    let parts = text.split(|c: char| c.is_control() || c == '\u{2028}' || c == '\u{2029}');
    parts.filter(|part| !part.is_empty()).collect::<Vec<_>>().join(" ")
}

fn io_line(path: &std::path::Path, action: &str, source: &io::Error) -> String {
    let (expected, remedy) = match (action, source.kind()) {
        ("read", io::ErrorKind::NotFound) => ("an existing file", "check the path or write the file first"),
        (_, io::ErrorKind::NotFound) => ("an existing folder", "create the folder first"),
        ("read", io::ErrorKind::PermissionDenied) => ("leave to read it", "change its permissions"),
        (_, io::ErrorKind::PermissionDenied) => {
            ("leave to write there", "change the folder's permissions or write elsewhere")
        }
        (
            "write" | "create",
            io::ErrorKind::StorageFull | io::ErrorKind::QuotaExceeded | io::ErrorKind::FileTooLarge,
        ) => ("room on the disk", "free some space or write elsewhere"),
        (_, io::ErrorKind::IsADirectory) => ("a file", "name a file, not a folder"),
        ("read", _) => ("a readable file", "check the file and its disk"),
        _ => ("a writable place", "check the folder and its disk"),
    };
    one_line(&format!("{}: {action}: found {source}, expected {expected}; {remedy}", path.display()))
}
