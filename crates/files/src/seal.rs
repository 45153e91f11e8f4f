//! What is checked of a file before its contents are trusted: its digest, its seal, and its kind.
//!
//! The seal is a digest of the file inside the file, which detects a single flipped byte. A sealed file holds
//! `"seal":"blake3:<64 hex digits>"` in its envelope, the digits being the BLAKE3 hash of the whole file with
//! these 64 characters replaced by zeros. `"seal":null` means unsealed.

use std::collections::BTreeMap;
use std::fmt;
use std::io::{Cursor, Read, Seek, SeekFrom};
use std::path::Path;
use std::str::FromStr;

use refusal::foreign;
use schemars::JsonSchema;
use serde::{Deserialize, Deserializer, Serialize};
use serde_json::Value;

use crate::error::{Error, Result};

const PREFIX: &str = "blake3:";

/// The BLAKE3 digest of a file's bytes, what `b3sum FILE` prints; as text `blake3:<64 hex digits>`.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize, JsonSchema)]
#[serde(try_from = "String", into = "String")]
#[schemars(with = "String", extend("pattern" = "^blake3:[0-9a-f]{64}$"))]
pub struct Digest([u8; 32]);

impl Digest {
    /// All digits zero: the placeholder in a seal while the file's digest is unknown.
    pub(crate) const ZERO: Self = Self([0; 32]);

    /// The digest of `bytes`.
    pub fn of_bytes(bytes: &[u8]) -> Self {
        blake3::hash(bytes).into()
    }

    /// The digest of the content of `reader`.
    pub(crate) fn of_reader(reader: impl Read) -> std::io::Result<Self> {
        Ok(blake3::Hasher::new().update_reader(reader)?.finalize().into())
    }

    /// The 64 lower-case hexadecimal digits, without the `blake3:` in front.
    pub fn hex(&self) -> String {
        blake3::Hash::from_bytes(self.0).to_hex().to_string()
    }
}

/// Hashes a source while reading it, so that it need not be read again for its digest.
#[derive(Debug)]
pub struct Digesting<R> {
    source: R,
    hasher: blake3::Hasher,
}

impl<R: Read> Digesting<R> {
    /// Reads `source` from its current position.
    pub fn new(source: R) -> Self {
        Self { source, hasher: blake3::Hasher::new() }
    }

    /// The digest of everything from there to the end, whether it was read or not.
    ///
    /// # Errors
    /// A source that cannot be read to its end.
    pub fn digest(mut self) -> std::io::Result<Digest> {
        Ok(self.hasher.update_reader(self.source)?.finalize().into())
    }
}

impl<R: Read> Read for Digesting<R> {
    fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
        let read = self.source.read(buffer)?;
        self.hasher.update(&buffer[..read]);
        Ok(read)
    }
}

impl From<blake3::Hash> for Digest {
    fn from(hash: blake3::Hash) -> Self {
        Self(hash.into())
    }
}

impl fmt::Display for Digest {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{PREFIX}{}", self.hex())
    }
}

impl fmt::Debug for Digest {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(self, f)
    }
}

impl From<Digest> for String {
    fn from(digest: Digest) -> Self {
        digest.to_string()
    }
}

/// Why a text is not a [`Digest`].
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("`{0}` is not a digest: expected `blake3:` and 64 lower-case hexadecimal digits")]
pub struct NotADigest(String);

impl FromStr for Digest {
    type Err = NotADigest;

    fn from_str(text: &str) -> Result<Self, NotADigest> {
        let hex = text.strip_prefix(PREFIX).unwrap_or_default();
        let lower = hex.bytes().all(|b| matches!(b, b'0'..=b'9' | b'a'..=b'f'));
        let hash = blake3::Hash::from_hex(hex).ok().filter(|_| lower);
        hash.map(Self::from).ok_or_else(|| NotADigest(text.to_owned()))
    }
}

impl TryFrom<String> for Digest {
    type Error = NotADigest;

    fn try_from(text: String) -> Result<Self, NotADigest> {
        text.parse()
    }
}

/// The placeholder of the digits while they are unknown.
const BLANK: [u8; DIGITS] = [b'0'; DIGITS];

/// Number of hexadecimal digits in a digest.
const DIGITS: usize = 64;

/// Digests of a file.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FileDigests {
    /// Of the bytes as they are.
    pub digest: Digest,
    /// Of the bytes with the seal's digits blanked, as in a valid seal.
    pub blanked: Digest,
}

/// Hashes a file in one pass; `digits_at` is the position of the seal's digits, if there is a seal.
pub(crate) fn digests(file: &mut (impl Read + Seek), digits_at: Option<u64>) -> std::io::Result<FileDigests> {
    file.seek(SeekFrom::Start(0))?;
    let mut hasher = blake3::Hasher::new();
    let Some(at) = digits_at else {
        hasher.update_reader(file)?;
        let digest = hasher.finalize().into();
        return Ok(FileDigests { digest, blanked: digest });
    };
    hasher.update_reader(file.by_ref().take(at))?;
    let mut blanked = hasher.clone();
    let mut digits = [0; DIGITS];
    file.read_exact(&mut digits)?;
    hasher.update(&digits);
    blanked.update(&BLANK);
    let mut rest = Vec::new();
    file.read_to_end(&mut rest)?;
    hasher.update(&rest);
    blanked.update(&rest);
    Ok(FileDigests { digest: hasher.finalize().into(), blanked: blanked.finalize().into() })
}

/// The position of the digits of `seal` in `text`.
pub(crate) fn digits_in(text: &str, seal: Digest) -> Option<usize> {
    let quoted = format!("\"{seal}\"");
    text.find(&quoted).map(|at| at + quoted.len() - 1 - DIGITS)
}

/// Refuses a file whose seal does not match its bytes. A missing seal is accepted.
pub(crate) fn check_seal(path: &Path, seal: Option<Digest>, digests: FileDigests) -> Result<()> {
    if seal.is_none_or(|seal| seal == digests.blanked) {
        return Ok(());
    }
    let digest = "a digest that differs from the file's bytes";
    let remedy = "the file is damaged: write it again (or, if you edited it by hand, set \"seal\" to null)";
    Err(Error::refuse(path, "seal", digest, digests.blanked.to_string(), remedy))
}

/// Writes the digits of the seal into the text of a document with a blank one.
///
/// The first blank seal in the text is the envelope's: only the schema id and the producer precede it, and
/// quotes inside a JSON string are escaped.
pub(crate) fn sealed(path: &Path, text: String) -> Result<Vec<u8>> {
    let blank = format!("\"seal\": \"{}\"", Digest::ZERO);
    let Some(at) = text.find(&blank).map(|at| at + blank.len() - 1 - DIGITS) else {
        unreachable!("the envelope has a blank seal")
    };
    let mut bytes = text.into_bytes();
    let digests = digests(&mut Cursor::new(&bytes), Some(at as u64));
    let digits = digests.map_err(|e| Error::io(path, "write", e))?.blanked.hex();
    bytes[at..at + DIGITS].copy_from_slice(digits.as_bytes());
    Ok(bytes)
}

/// Refuses a seal that does not match.
pub(crate) fn check_text(path: &Path, text: &str, seal: Option<Digest>) -> Result<FileDigests> {
    let at = seal.and_then(|seal| digits_in(text, seal));
    let digests = digests(&mut Cursor::new(text.as_bytes()), at.map(|at| at as u64));
    let digests = digests.map_err(|e| Error::io(path, "read", e))?;
    check_seal(path, seal, digests)?;
    Ok(digests)
}

/// Reads the value of a `seal` key, which must be there but may be null.
pub(crate) fn required<'de, D: Deserializer<'de>>(source: D) -> Result<Option<Digest>, D::Error> {
    Option::deserialize(source)
}

/// The text that names a kind of file and its version: `trajectories/1`.
pub(crate) fn schema_id(id: &str, version: u32) -> String {
    format!("{id}/{version}")
}

fn version_remedy(stated: &str, expected: u32) -> String {
    let again = "write the file again with this version";
    match stated.parse::<u64>() {
        Ok(version) if version > u64::from(expected) => format!("upgrade seatrial or {again}"),
        _ => again.to_owned(),
    }
}

/// The part that is read before the contents are trusted; the rest of the envelope is skipped.
#[derive(Deserialize)]
pub(crate) struct Header {
    #[serde(default)]
    schema: Value,
    #[serde(default)]
    seal: Value,
    #[serde(default)]
    members: Value,
}

impl Header {
    /// Refuses a file of unknown kind, of another kind, and of another version.
    pub fn check(&self, path: &Path, id: &str, version: u32) -> Result<()> {
        let expected = schema_id(id, version);
        let Some(schema) = self.schema.as_str() else {
            let remedy = format!("name a file of kind {id}");
            return Err(Error::refuse(path, "schema", "no schema id", expected, remedy));
        };
        if schema == expected {
            return Ok(());
        }
        let remedy = match schema.split_once('/') {
            Some((kind, number)) if kind == id => version_remedy(number, version),
            _ => refusal::gone(schema).map_or_else(|| format!("name a file of kind {id}"), str::to_owned),
        };
        Err(Error::refuse(path, "schema", foreign(schema), expected, remedy))
    }

    /// Kind and version, if stated.
    pub fn schema(&self) -> Option<&str> {
        self.schema.as_str()
    }

    /// The seal. If it is missing or not a digest, the strict reading of the envelope will refuse that.
    pub fn seal(&self) -> Option<Digest> {
        self.seal.as_str().and_then(|text| text.parse().ok())
    }

    /// The digests of the files that were written together with this one.
    pub fn members(self) -> BTreeMap<String, Digest> {
        serde_json::from_value(self.members).unwrap_or_default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blanking_changes_only_the_blanked_digest() {
        let mut bytes = vec![7; 1000];
        bytes[300..364].fill(b'a');
        let sealed = digests(&mut Cursor::new(&bytes), Some(300)).unwrap();
        assert_eq!(sealed.digest, Digest::of_bytes(&bytes));
        bytes[300..364].copy_from_slice(&BLANK);
        assert_eq!(sealed.blanked, Digest::of_bytes(&bytes));
    }

    #[test]
    fn a_place_beyond_the_end_is_an_error() {
        assert!(digests(&mut Cursor::new(vec![7; 100]), Some(90)).is_err());
    }
}
