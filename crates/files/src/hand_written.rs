//! Hand-written input.

use std::ops::Range;
use std::path::Path;

use refusal::{Contents, Unreadable};
use serde::de::{Deserialize, DeserializeOwned};

use crate::access::{bytes_of, open, read};
use crate::changes::Changes;
use crate::error::{Complaint, Error, Result};
use crate::seal::Digest;
use crate::toml_place::{Place, key_at, line_and_column, place_of, span_of};

/// Reads a TOML file.
///
/// # Errors
/// [`Error::Io`] if it cannot be read; [`Error::Refused`] as in [`parse_toml`].
pub fn read_toml<T: DeserializeOwned>(path: impl AsRef<Path>) -> Result<(T, Digest)> {
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
pub(crate) fn read_changed<T: DeserializeOwned>(
    path: &Path,
    file: &str,
    changes: &Changes,
) -> Result<(T, Digest)> {
    if changes.of(file).next().is_none() {
        return read_toml(path);
    }
    let text = read_hand_written(path)?;
    // A fault of the file itself is reported with its line.
    let own = |refused: Error| parse_toml::<T>(&text, path).err().unwrap_or(refused);
    let changed = changes.applied(file, &text).map_err(|e| own(Error::invalid(path, e)))?;
    let parsed = parsed(&changed)
        .map_err(|fault| own(fault.complaint(&changed, path).changed(&changes.in_words(file)).refusal()))?;
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
        let found = format!("a byte that is not UTF-8 (line {line})");
        Error::refuse(path, "text", found, "UTF-8 text", "save the file as UTF-8 or write it again")
    })
}

/// Parses TOML; messages name the file `path`.
///
/// # Errors
/// [`Error::Refused`] on a syntax error, an unknown key (with the nearest known key), a missing
/// key, a wrong type, a list where keys belong or an unknown choice, always with the line.
pub fn parse_toml<T: DeserializeOwned>(text: &str, path: impl AsRef<Path>) -> Result<T> {
    parsed(text).map_err(|fault| fault.complaint(text, path.as_ref()).refusal())
}

/// What is wrong with a text, and where.
struct Fault {
    message: String,
    span: Option<Range<usize>>,
}

fn parsed<T: DeserializeOwned>(text: &str) -> Result<T, Fault> {
    let contents = toml::Deserializer::parse(text).and_then(Contents::deserialize);
    let contents = contents.map_err(|e| Fault { message: e.message().to_owned(), span: e.span() })?;
    let fault = |Unreadable { message, way, is_key }| Fault { message, span: span_of(text, &way, is_key) };
    contents.read().map_err(fault)
}

impl Fault {
    fn complaint<'a>(&'a self, text: &str, path: &'a Path) -> Complaint<'a> {
        complaint(text, path, &self.message, self.span.clone())
    }
}

fn complaint<'a>(text: &str, path: &'a Path, message: &'a str, span: Option<Range<usize>>) -> Complaint<'a> {
    // Items of a list are read as they are, without their places: the message names the item and the key.
    let named = message.rsplit_once(" (").and_then(|(message, item)| {
        let key = message.split('`').nth(1).unwrap_or_default();
        let item = item.trim_end_matches(')');
        place_of(text, &format!("{item}, `{key}`"), None).or_else(|| place_of(text, item, None))
    });
    let place = span.as_ref().and_then(|span| key_at(text, span));
    // Of a wrong value the key before it.
    let start = span.map(|span| match &place {
        Some(Place { at, .. }) if line_at(text.as_bytes(), *at) == line_at(text.as_bytes(), span.start) => {
            *at
        }
        _ => span.start,
    });
    let at = named.or(start);
    let place_in = at.map(|at| line_and_column(text, at));
    let inner = message.rsplit_once(" (").and_then(|(_, item)| item.split('`').nth(3));
    let key = inner.map(str::to_owned).or(place.map(|place| place.key));
    Complaint { path, place: place_in, key, message }
}

/// Number, from 1, of the line that holds byte `at`.
fn line_at(text: &[u8], at: usize) -> usize {
    1 + text.iter().take(at).filter(|&&byte| byte == b'\n').count()
}
