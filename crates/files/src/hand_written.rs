//! Hand-written input, and values that replace its own.

use std::fmt;
use std::ops::Range;
use std::path::Path;
use std::str::FromStr;

use refusal::{Contents, Invalid, Unreadable};
use schemars::JsonSchema;
use serde::de::{Deserialize, DeserializeOwned, Error as _};
use toml::{Table, Value};

use crate::access::{bytes_of, open, read};
use crate::error::{Complaint, Error, Result};
use crate::seal::Digest;
use crate::toml_place::{key_at, line_and_column, place_of, span_of};

/// Reads a TOML file.
///
/// # Errors
/// [`Error::Io`] if it cannot be read; [`Error::Refused`] as in [`parse_toml`].
pub fn read_toml<T: DeserializeOwned + JsonSchema>(path: impl AsRef<Path>) -> Result<(T, Digest)> {
    let path = path.as_ref();
    let text = read_hand_written(path)?;
    Ok((parse_toml(&text, path)?, Digest::of_bytes(text.as_bytes())))
}

/// Maximum bytes of a hand-written file: its values take many times the memory.
const LONGEST: u64 = 16 << 20;

/// The text of the hand-written file at `path`.
///
/// # Errors
/// As [`read_to_string`]; [`Error::Refused`] if it is longer than anyone writes.
pub fn read_hand_written(path: impl AsRef<Path>) -> Result<String> {
    let path = path.as_ref();
    let file = open(path)?;
    let length = file.metadata().map_err(|e| Error::io(path, "read", e))?.len();
    if length > LONGEST {
        let (found, expected) = (format!("{length} bytes"), format!("at most {LONGEST}, written by hand"));
        return Err(Error::refuse(path, "file", found, expected, "shorten it"));
    }
    text_of(path, bytes_of(path, file)?)
}

/// As [`read_toml`], with those of `changes` that concern `file`, the usual name without `.toml`. The digest
/// is that of the changed contents.
pub(crate) fn read_changed<T: DeserializeOwned + JsonSchema>(
    path: &Path,
    file: &str,
    changes: &Changes,
) -> Result<(T, Digest)> {
    if changes.of(file).next().is_none() {
        return read_toml(path);
    }
    let text = read_hand_written(path)?;
    // A fault of the file itself is reported with its line.
    let of_file = |refused: Error| parse_toml::<T>(&text, path).err().unwrap_or(refused);
    let changed = changes.applied(file, &text).map_err(|e| of_file(Error::invalid(path, e)))?;
    let in_words = changes.in_words(file);
    let parsed =
        parsed(&changed).map_err(|fault| of_file(refusal(&changed, path, fault, Some(&in_words))))?;
    Ok((parsed, Digest::of_bytes(changed.as_bytes())))
}

/// The text of the ordinary file at `path`.
///
/// # Errors
/// As [`read`]; [`Error::Refused`] if it is not UTF-8.
pub fn read_to_string(path: impl AsRef<Path>) -> Result<String> {
    let path = path.as_ref();
    text_of(path, read(path)?)
}

/// The bytes of `path` as text.
pub(crate) fn text_of(path: &Path, bytes: Vec<u8>) -> Result<String> {
    String::from_utf8(bytes).map_err(|e| {
        let at = e.utf8_error().valid_up_to();
        let line = line_at(e.as_bytes(), at);
        let byte = format!("a byte that is not UTF-8 (line {line})");
        Error::refuse(path, "text", byte, "UTF-8 text", "save the file as UTF-8 or write it again")
    })
}

/// Parses TOML; messages name the file `path`.
///
/// # Errors
/// [`Error::Refused`] on a syntax error, an unknown key (with the nearest known key), a missing
/// key, a wrong type, a list where keys belong, an unknown choice or a number out of bounds, always with the line.
pub fn parse_toml<T: DeserializeOwned + JsonSchema>(text: &str, path: impl AsRef<Path>) -> Result<T> {
    parsed(text).map_err(|fault| refusal(text, path.as_ref(), fault, None))
}

/// A refusal of `text`, in which `changes` replaced values: it then has no lines.
fn refusal(
    text: &str,
    path: &Path,
    (fault, span): (Unreadable, Option<Range<usize>>),
    changes: Option<&str>,
) -> Error {
    let Some(mut invalid) = fault.invalid else {
        let complaint = complaint(text, path, &fault.message, span);
        return changes.map_or(complaint.refusal(), |changes| complaint.changed(changes).refusal());
    };
    let place = span.filter(|_| changes.is_none()).map(|span| line_and_column(text, span.start));
    invalid.found += &place.map_or(String::new(), |place| format!(" ({place})"));
    Error::Refused { file: path.into(), invalid: *invalid }
}

/// `text` as TOML; else what is wrong, and where.
fn parsed<T: DeserializeOwned + JsonSchema>(text: &str) -> Result<T, (Unreadable, Option<Range<usize>>)> {
    let contents = toml::Deserializer::parse(text).and_then(Contents::deserialize);
    let contents = contents.map_err(|e| (Unreadable::custom(e.message()), e.span()))?;
    contents.read().map_err(|fault| {
        let span = span_of(text, &fault.way, fault.is_key);
        (fault, span)
    })
}

fn complaint<'a>(text: &str, path: &'a Path, message: &'a str, span: Option<Range<usize>>) -> Complaint<'a> {
    let parts = message.rsplit_once(" (");
    // Items of a list are read as they are, without their places: the message names the item and the key.
    let named = parts.and_then(|(message, item)| {
        let key = message.split('`').nth(1).unwrap_or_default();
        let item = item.trim_end_matches(')');
        place_of(text, &format!("{item}, `{key}`"), None).or_else(|| place_of(text, item, None))
    });
    let place = span.as_ref().and_then(|span| key_at(text, span));
    // Of a wrong value the key before it.
    let start = span.as_ref().map(|span| match &place {
        Some((_, at)) if line_at(text.as_bytes(), *at) == line_at(text.as_bytes(), span.start) => *at,
        _ => span.start,
    });
    let at = named.or(start).map(|at| line_and_column(text, at));
    let inner = parts.and_then(|(_, item)| item.split('`').nth(3));
    let key = inner.map(str::to_owned).or(place.map(|(key, _)| key));
    Complaint { path, place: at, key, message }
}

/// Number, from 1, of the line that holds byte `at`.
fn line_at(text: &[u8], at: usize) -> usize {
    1 + text.iter().take(at).filter(|&&byte| byte == b'\n').count()
}

/// A replacement for a value in a hand-written file: `campaign.realizations=100`.
#[derive(Clone, Debug, PartialEq)]
pub struct Change {
    file: String,
    keys: Vec<String>,
    value: Value,
}

/// Replacements for values in a study's hand-written files, each at most once.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Changes(Vec<Change>);

impl Change {
    /// Replaces the value at the dotted `key`, which begins with the file's usual name without `.toml`.
    ///
    /// # Errors
    /// A malformed key, or one that names only the file.
    pub fn new(key: &str, value: Value) -> Result<Self, Invalid> {
        let mut keys = dotted(key).unwrap_or_default().into_iter();
        let (file, keys) = (keys.next().unwrap_or_default(), keys.collect::<Vec<_>>());
        if keys.is_empty() {
            let expected =
                "a file's usual name without `.toml` and a key in it, such as campaign.current.std_m_s";
            let remedy = "correct it, with quotes around a part that is no plain word";
            return Err(Invalid::new("key", format!("`{key}`"), expected, remedy));
        }
        Ok(Self { file, keys, value })
    }

    /// Usual name, without `.toml`, of its file.
    pub fn file(&self) -> &str {
        &self.file
    }

    /// The dotted key, with the file.
    pub fn key(&self) -> String {
        let plain = |key: &String| key.chars().all(|c| c.is_ascii_alphanumeric() || matches!(c, '_' | '-'));
        let written =
            |key: &String| if plain(key) { key.clone() } else { Value::from(key.as_str()).to_string() };
        std::iter::once(&self.file).chain(&self.keys).map(written).collect::<Vec<_>>().join(".")
    }

    /// The value.
    pub fn value(&self) -> &Value {
        &self.value
    }

    /// Applies the replacement to `file`. A missing table is created; an item of a list is identified by its
    /// `name` or its index from 0.
    fn apply(&self, file: &mut Table) -> Result<(), Invalid> {
        let mut whole = Value::Table(std::mem::take(file));
        let mut place = Ok(&mut whole);
        for key in &self.keys {
            place = place.and_then(|value| self.below(value, key));
        }
        let placed = place.map(|place| *place = self.value.clone());
        if let Value::Table(changed) = whole {
            *file = changed;
        }
        placed
    }

    /// The value at `key` in `value`.
    fn below<'a>(&self, value: &'a mut Value, key: &str) -> Result<&'a mut Value, Invalid> {
        let thing = format!("`{}`", self.key());
        match value {
            Value::Table(table) => Ok(table.entry(key).or_insert_with(|| Table::new().into())),
            Value::Array(list) => {
                let names: Vec<String> =
                    list.iter().enumerate().map(|(i, item)| item_name(i, item)).collect();
                let place = names.iter().position(|name| name == key).or_else(|| key.parse().ok());
                let unknown = || Invalid::unknown(thing, key, names.iter().map(String::as_str));
                place.and_then(|place| list.get_mut(place)).ok_or_else(unknown)
            }
            other => {
                let (found, remedy) = (format!("`{key}` below {other}"), "name the key of the value itself");
                Err(Invalid::new(thing, found, "keys below a table or a list", remedy))
            }
        }
    }
}

/// The identification of an item of a list: its `name`, or its index.
fn item_name(place: usize, item: &Value) -> String {
    let name = item.get("name").and_then(Value::as_str);
    name.map_or_else(|| place.to_string(), str::to_owned)
}

/// The parts of a dotted key, as TOML reads them.
fn dotted(key: &str) -> Option<Vec<String>> {
    let mut table: Table = toml::from_str(&format!("{key} = 0")).ok()?;
    let mut keys = Vec::new();
    loop {
        let mut entries = std::mem::take(&mut table).into_iter();
        let ((key, value), None) = (entries.next()?, entries.next()) else { return None };
        keys.push(key);
        match value {
            Value::Table(below) => table = below,
            _ => return Some(keys),
        }
    }
}

/// `text` as a TOML value; as a string if it is not one.
fn value_of(text: &str) -> Value {
    let mut table: Table = toml::from_str(&format!("value = {text}")).unwrap_or_default();
    let value = table.remove("value").filter(|_| table.is_empty());
    value.unwrap_or_else(|| text.into())
}

impl FromStr for Change {
    type Err = Invalid;

    fn from_str(text: &str) -> Result<Self, Invalid> {
        match text.split_once('=') {
            Some((key, value)) => Self::new(key, value_of(value)),
            None => Err(Invalid::new("change", format!("`{text}`"), "FILE.KEY=VALUE", "add = and a value")),
        }
    }
}

/// As on the command line.
impl fmt::Display for Change {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}={}", self.key(), self.value)
    }
}

impl Changes {
    /// All of `changes`.
    ///
    /// # Errors
    /// A key that two of them have.
    pub fn new(changes: Vec<Change>) -> Result<Self, Invalid> {
        let twice = changes.iter().enumerate().find(|(i, change)| {
            changes[..*i].iter().any(|other| other.file == change.file && other.keys == change.keys)
        });
        match twice {
            Some((_, change)) => {
                Err(Invalid::new(format!("`{}`", change.key()), "it twice", "every key once", "remove one"))
            }
            None => Ok(Self(changes)),
        }
    }

    /// Those of `file`, a usual name without `.toml`.
    pub fn of<'a>(&'a self, file: &'a str) -> impl Iterator<Item = &'a Change> {
        self.0.iter().filter(move |change| change.file == file)
    }

    /// All of them.
    pub fn iter(&self) -> impl Iterator<Item = &Change> {
        self.0.iter()
    }

    /// `text`, which is the TOML of `file`, with the replacements applied.
    ///
    /// # Errors
    /// Text that is no TOML; a replacement of what is not there.
    pub fn applied(&self, file: &str, text: &str) -> Result<String, Invalid> {
        let mut table: Table = toml::from_str(text).map_err(|e| {
            Invalid::new("text", e.message(), "TOML with numbers of 64 bits and a sign", "correct it")
        })?;
        self.of(file).try_for_each(|change| change.apply(&mut table))?;
        Ok(table.to_string())
    }

    /// The replacements for `file`, as a list in words.
    pub(crate) fn in_words(&self, file: &str) -> String {
        self.of(file).map(Change::to_string).collect::<Vec<_>>().join(", ")
    }
}
