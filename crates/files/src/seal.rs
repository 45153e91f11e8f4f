//! The seal: a digest of the file inside the file, which detects a single flipped byte.
//!
//! A sealed file holds `"seal":"blake3:<64 hex digits>"` in its envelope, the digits being the BLAKE3
//! hash of the whole file with these 64 characters replaced by zeros. `"seal":null` means unsealed.

use std::io::{Cursor, Read, Seek, SeekFrom};
use std::path::Path;

use serde::{Deserialize, Deserializer};

use crate::digest::Digest;
use crate::error::{Error, Result};

/// The placeholder of the digits while they are unknown.
pub(crate) const BLANK: [u8; DIGITS] = [b'0'; DIGITS];

/// Number of hexadecimal digits in a digest.
pub(crate) const DIGITS: usize = 64;

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
pub(crate) fn check(path: &Path, seal: Option<Digest>, digests: FileDigests) -> Result<()> {
    if seal.is_none_or(|seal| seal == digests.blanked) {
        return Ok(());
    }
    let found = "a digest that differs from the file's bytes";
    let remedy = "the file is damaged: write it again (or, if you edited it by hand, set \"seal\" to null)";
    Err(Error::refuse(path, "seal", found, digests.blanked.to_string(), remedy))
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
    check(path, seal, digests)?;
    Ok(digests)
}

/// Reads the value of a `seal` key, which must be there but may be null.
pub(crate) fn required<'de, D: Deserializer<'de>>(
    source: D,
) -> std::result::Result<Option<Digest>, D::Error> {
    Option::deserialize(source)
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
