//! Errors, each reported in one line.

use std::convert::Infallible;
use std::io;
use std::path::{Path, PathBuf};

use refusal::{Invalid, one_line, shortened};

use crate::toml_place::placed;

/// Result of this crate's functions.
pub type Result<T> = std::result::Result<T, Error>;

/// Bad input, or failed input and output.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The contents of a file, or data to be written, are not acceptable.
    #[error("{}: {invalid}", shown(.file))]
    Refused {
        /// The file that holds the thing; for a block not yet in a file, the table's schema id.
        file: PathBuf,
        /// What is wrong in it.
        invalid: Invalid,
    },
    /// The operating system refused to read or write.
    #[error("{}", io_line(.path, .action, .source))]
    Io {
        /// The file or folder.
        path: PathBuf,
        /// The failed operation: `read`, `write`, `create`, `rename`, `put channels aside`.
        action: &'static str,
        /// The operating system's answer.
        source: io::Error,
    },
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
        Self::invalid(file, Invalid::new(thing, found, expected, remedy))
    }

    /// An [`Error::Refused`]: what is invalid in `file`; of a hand-written one, with the line and the column if it stands there.
    pub fn invalid(file: impl Into<PathBuf>, invalid: Invalid) -> Self {
        let file = file.into();
        let invalid = placed(&file, invalid);
        Self::Refused { file, invalid }
    }

    /// An [`Error::Io`] from its parts; an [`Error::Refused`] for a name that no file can have.
    pub fn io(path: impl Into<PathBuf>, action: &'static str, source: io::Error) -> Self {
        if source.kind() == io::ErrorKind::InvalidInput && action == "read" {
            return Self::refuse(
                path,
                "file",
                source.to_string(),
                "a name that a file can have",
                "correct it",
            );
        }
        Self::Io { path: path.into(), action, source }
    }
}

/// Most characters of the operating system's or a library's answer in a message.
const SOURCE: usize = 200;

/// Most characters of a path in a message.
const PATH: usize = 120;

/// `path` in one line; for a long one only its end, which is the most specific.
fn shown(path: &Path) -> String {
    let path = one_line(&path.display().to_string());
    match path.chars().count() {
        0 => "a file without a name".to_owned(),
        1..=PATH => path,
        length => ['…'].into_iter().chain(path.chars().skip(length - PATH + 1)).collect(),
    }
}

fn io_line(path: &Path, action: &str, source: &io::Error) -> String {
    let (expected, remedy) = match (action, source.kind()) {
        ("read", io::ErrorKind::NotFound) => ("an existing file", "check the path or write the file first"),
        (_, io::ErrorKind::NotFound) => ("an existing folder", "create the folder first"),
        ("read", io::ErrorKind::PermissionDenied) => ("permission to read it", "change its permissions"),
        (_, io::ErrorKind::PermissionDenied) => {
            ("permission to write there", "change the folder's permissions or write elsewhere")
        }
        (
            "write" | "create" | "put channels aside",
            io::ErrorKind::StorageFull | io::ErrorKind::QuotaExceeded | io::ErrorKind::FileTooLarge,
        ) => ("room on the disk", "free some space or write elsewhere"),
        (_, io::ErrorKind::IsADirectory) => ("a file", "name a file, not a folder"),
        ("read", io::ErrorKind::NotADirectory) => ("a folder before its name", "check the path"),
        ("read", _) => ("a readable file", "check the file and its disk"),
        _ => ("a writable place", "check the folder and its disk"),
    };
    let found = shortened(&one_line(&source.to_string()), SOURCE);
    format!("{}: {action}: found {found}, expected {expected}; {remedy}", shown(path))
}

/// Readers of data in memory never fail.
impl From<Infallible> for Error {
    fn from(never: Infallible) -> Self {
        match never {}
    }
}
