//! Hand-written input.

use std::path::Path;

use refusal::strictly;
use serde::de::DeserializeOwned;

use crate::changes::Changes;
use crate::complaint::Complaint;
use crate::digest::Digest;
use crate::error::{Error, Result};
use crate::ordinary::read;

/// Reads a TOML file.
///
/// # Errors
/// [`Error::Io`] if it cannot be read; [`Error::Refused`] as in [`parse_toml`].
pub fn read_toml<T: DeserializeOwned>(path: impl AsRef<Path>) -> Result<(T, Digest)> {
    let path = path.as_ref();
    let bytes = read(path)?;
    let digest = Digest::of_bytes(&bytes);
    let text = text_of(path, bytes)?;
    Ok((parse_toml(&text, path)?, digest))
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
    let text = read_to_string(path)?;
    // A fault of the file itself is reported with its line.
    let own = |refused: Error| parse_toml::<T>(&text, path).err().unwrap_or(refused);
    let changed = changes.applied(file, &text).map_err(|e| own(Error::invalid(path, e)))?;
    let parsed = toml::Deserializer::parse(&changed).and_then(strictly);
    let parsed =
        parsed.map_err(|e| own(complaint(&changed, path, &e).changed(&changes.in_words(file)).refusal()))?;
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
    let parsed = toml::Deserializer::parse(text).and_then(strictly);
    parsed.map_err(|e| complaint(text, path.as_ref(), &e).refusal())
}

fn complaint<'a>(text: &str, path: &'a Path, error: &'a toml::de::Error) -> Complaint<'a> {
    let start = error.span().map(|span| span.start);
    let place = start.map(|at| format!("line {}", line_at(text.as_bytes(), at)));
    Complaint { path, place, key: start.and_then(|at| key_at(text, at)), message: error.message() }
}

/// Number, from 1, of the line that holds byte `at`.
fn line_at(text: &[u8], at: usize) -> usize {
    1 + text.iter().take(at).filter(|&&byte| byte == b'\n').count()
}

/// The key on the line that holds byte `at`, as in `key = value`.
fn key_at(text: &str, at: usize) -> Option<String> {
    let line = text.lines().nth(line_at(text.as_bytes(), at) - 1)?;
    let (key, _) = line.split_once('=')?;
    let key = key.trim();
    let plain = |c: char| c.is_alphanumeric() || matches!(c, '_' | '-' | '.' | '"' | '\'');
    (!key.is_empty() && key.chars().all(plain)).then(|| key.to_owned())
}
