//! Digests of files.

use std::fmt;
use std::io::Read;
use std::str::FromStr;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

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

    fn from_str(text: &str) -> std::result::Result<Self, NotADigest> {
        let hex = text.strip_prefix(PREFIX).unwrap_or_default();
        let lower = hex.bytes().all(|b| matches!(b, b'0'..=b'9' | b'a'..=b'f'));
        let hash = blake3::Hash::from_hex(hex).ok().filter(|_| lower);
        hash.map(Self::from).ok_or_else(|| NotADigest(text.to_owned()))
    }
}

impl TryFrom<String> for Digest {
    type Error = NotADigest;

    fn try_from(text: String) -> std::result::Result<Self, NotADigest> {
        text.parse()
    }
}
