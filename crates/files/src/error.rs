//! Errors, each reported in one line.

use std::convert::Infallible;
use std::io;
use std::path::{Path, PathBuf};

use refusal::{Invalid, foreign, one_line, shortened};

use crate::toml_place::placed;

/// Result of this crate's functions.
pub type Result<T, E = Error> = std::result::Result<T, E>;

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
            let expected = "a name that a file can have";
            return Self::refuse(path, "file", source.to_string(), expected, "correct it");
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
        // Windows: a sharing or lock violation
        _ if cfg!(windows) && matches!(source.raw_os_error(), Some(32 | 33)) => {
            ("a file that no other program has open", "close it there")
        }
        ("rename", io::ErrorKind::PermissionDenied) if cfg!(windows) => (
            "permission to replace it",
            "close it where it is open, change the folder's permissions or write elsewhere",
        ),
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
    let answer = shortened(&one_line(&source.to_string()), SOURCE);
    format!("{}: {action}: found {answer}, expected {expected}; {remedy}", shown(path))
}

/// Readers of data in memory never fail.
impl From<Infallible> for Error {
    fn from(never: Infallible) -> Self {
        match never {}
    }
}

/// A message of serde, with its place; its refusal suggests the nearest known word.
pub(crate) struct Complaint<'a> {
    /// The file.
    pub path: &'a Path,
    /// Its place in the file, as `line 3`, if known.
    pub place: Option<String>,
    /// The key there, if known.
    pub key: Option<String>,
    /// serde's message, without a line number.
    pub message: &'a str,
}

impl Complaint<'_> {
    /// The complaint about the file after `changes`, which has no line numbers.
    pub fn changed(self, changes: &str) -> Self {
        Self { place: Some(format!("with {changes}")), ..self }
    }

    /// The refusal in this crate's form.
    pub fn refusal(&self) -> Error {
        let message = self.message.lines().next().unwrap_or_default().trim_end_matches('.');
        let (message, remark) = split_remark(message);
        let place: Vec<String> = self.place.clone().into_iter().chain(remark.map(str::to_owned)).collect();
        let line = if place.is_empty() { String::new() } else { format!(" ({})", place.join(", ")) };
        let refuse = |thing: &str, found: String, expected: String, remedy: String| {
            Error::refuse(self.path, thing, format!("{found}{line}"), expected, remedy)
        };
        for (kind, prefix) in [("key", "unknown field "), ("value", "unknown variant ")] {
            let Some((word, known)) = strange_word(message, prefix) else { continue };
            let (thing, named) = match kind {
                "key" => (kind.to_owned(), "key "),
                _ => (foreign(self.key.as_deref().unwrap_or(kind)), ""),
            };
            let strange = format!("{named}`{}`", foreign(&word));
            return refuse(&thing, strange, one_of(kind, &known), suggestion(&word, &known));
        }
        if let Some(field) = message.strip_prefix("missing field ") {
            let remedy = format!("add {field}");
            return refuse("key", format!("no key {field}"), format!("a value for {field}"), remedy);
        }
        self.other(message, &line)
    }

    /// Wrong types, wrong lengths, duplicate keys, and messages of the program's own types.
    fn other(&self, message: &str, line: &str) -> Error {
        let thing = foreign(self.key.as_deref().unwrap_or("contents"));
        let of_type = ["invalid type: ", "invalid value: ", "invalid length "];
        let stripped = of_type.iter().find_map(|prefix| message.strip_prefix(prefix)).unwrap_or(message);
        let (value, expected) =
            stripped.split_once(", expected ").unwrap_or((stripped, "an acceptable value"));
        let value = format!("{}{line}", plain_value(value));
        Error::refuse(self.path, thing, value, plain_type(expected), "correct the value")
    }
}

/// serde's name of a value, in terms of the file.
fn plain_value(value: &str) -> String {
    match value.split_once(' ') {
        Some(("integer", number)) => format!("the number {}", number.trim_matches('`')),
        Some(("floating", rest)) => {
            format!("the number {}", rest.trim_start_matches("point ").trim_matches('`'))
        }
        Some(("string", text)) => format!("the text {text}"),
        Some(("boolean", value)) => value.trim_matches('`').to_owned(),
        _ if value == "sequence" => "a list".to_owned(),
        _ if value == "map" => "a table".to_owned(),
        _ => value.to_owned(),
    }
}

/// serde's name of a type, in terms of the file.
fn plain_type(expected: &str) -> String {
    match expected {
        "u8" | "u16" | "u32" | "u64" | "usize" | "a nonzero u32" | "a nonzero u64" => {
            "a whole number from 0".to_owned()
        }
        "i8" | "i16" | "i32" | "i64" | "isize" => "a whole number".to_owned(),
        "f32" | "f64" => "a number".to_owned(),
        "a string" => "a text".to_owned(),
        "a boolean" => "true or false".to_owned(),
        "a sequence" => "a list".to_owned(),
        "a map" => "a table".to_owned(),
        other => match (other.strip_prefix("an array of length "), other.strip_prefix("a tuple of size ")) {
            (Some(length), _) | (_, Some(length)) => format!("a list of {length} values"),
            _ if other.starts_with("struct ") => "a table".to_owned(),
            _ => other.to_owned(),
        },
    }
}

/// Separates a message from the location in round brackets that a program's own type has appended to it.
fn split_remark(message: &str) -> (&str, Option<&str>) {
    match message.strip_suffix(')').and_then(|rest| rest.rsplit_once(" (")) {
        Some((message, remark)) => (message, Some(remark)),
        None => (message, None),
    }
}

/// The unknown word and the known ones in ``unknown field `x`, expected one of `a`, `b` ``.
fn strange_word(message: &str, prefix: &str) -> Option<(String, Vec<String>)> {
    let rest = message.strip_prefix(prefix)?;
    let (word, known) = match rest.split_once("`, ") {
        Some((word, known)) => {
            (word.strip_prefix('`')?, known.split('`').skip(1).step_by(2).map(str::to_owned).collect())
        }
        None => (rest.trim_matches('`'), Vec::new()),
    };
    Some((word.to_owned(), known))
}

fn one_of(thing: &str, known: &[String]) -> String {
    match known {
        [] => format!("no {thing} here"),
        [only] => format!("the {thing} `{only}`"),
        all => {
            let all: Vec<String> = all.iter().map(|word| format!("`{word}`")).collect();
            format!("a known {thing}: {}", all.join(", "))
        }
    }
}

fn suggestion(word: &str, known: &[String]) -> String {
    let near = refusal::suggestion(word, known.iter().map(String::as_str));
    near.unwrap_or_else(|| format!("remove `{}`", foreign(word)))
}
