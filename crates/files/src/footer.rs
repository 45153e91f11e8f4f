//! The footer of a Parquet file as bytes: finding the envelope before anything is decoded.
//!
//! The seal is checked before the parquet crate sees the file, so the envelope is found by the bytes that
//! precede it in the compact Thrift encoding of a key and its value.

use std::io::{Read, Seek, SeekFrom};
use std::ops::Range;
use std::path::Path;

use parquet::errors::{ParquetError, Result as ParquetResult};
use parquet::file::metadata::{ParquetMetaData, ParquetMetaDataOptions, ParquetMetaDataReader};

use crate::error::{Error, Result};
use crate::layout::KEY;
use crate::seal::Digest;
use crate::thrift::most_bytes;
use crate::{seal, thrift};

const MAGIC: &[u8; 4] = b"PAR1";

/// Length of the footer's length and the magic number at the end of the file.
const TAIL: u64 = 8;

/// A string field that follows the field before it, in compact Thrift.
const STRING_FIELD: u8 = 0x18;

/// The footer of a file, with the position of the envelope in it.
pub(crate) struct Footer {
    /// The encoded file metadata, without length and magic number.
    pub bytes: Vec<u8>,
    start: u64,
    envelope: Range<usize>,
}

impl Footer {
    /// Reads the footer of the file at `path`, already open as `file`.
    pub fn read(path: &Path, file: &mut (impl Read + Seek)) -> Result<Self> {
        let (start, bytes) = bytes_of(file).map_err(|e| Error::io(path, "read", e))?.ok_or_else(|| {
            let remedy = "the file is truncated, damaged or of another format: write it again";
            Error::refuse(path, "file", "no Parquet header or footer", "a whole Parquet file", remedy)
        })?;
        let envelope = find_envelope(&bytes).ok_or_else(|| {
            let remedy = "name a file that seatrial wrote, or bring this one in with `ingest`";
            let found = format!("no `{KEY}` metadata");
            Error::refuse(path, "file", found, "a table with schema and units", remedy)
        })?;
        Ok(Self { bytes, start, envelope })
    }

    /// The JSON text of the envelope.
    pub fn envelope(&self, path: &Path) -> Result<&str> {
        std::str::from_utf8(&self.bytes[self.envelope.clone()]).map_err(|_| {
            let found = "a text that is not UTF-8";
            Error::refuse(path, "metadata", found, "JSON", "the file is damaged: write it again")
        })
    }

    /// Where in the file the digits of `seal` start.
    pub fn seal_digits_at(&self, path: &Path, seal: Digest) -> Result<Option<u64>> {
        let at = seal::digits_in(self.envelope(path)?, seal);
        Ok(at.map(|at| self.start + (self.envelope.start + at) as u64))
    }
}

/// Position and bytes of the footer, or `None` if this is not a whole Parquet file, or if the footer does not
/// fit in memory.
pub(crate) fn bytes_of(file: &mut (impl Read + Seek)) -> std::io::Result<Option<(u64, Vec<u8>)>> {
    let length = file.seek(SeekFrom::End(0))?;
    if length < MAGIC.len() as u64 + TAIL {
        return Ok(None);
    }
    let (mut head, mut size, mut magic) = ([0; 4], [0; 4], [0; 4]);
    file.seek(SeekFrom::Start(0))?;
    file.read_exact(&mut head)?;
    file.seek(SeekFrom::Start(length - TAIL))?;
    file.read_exact(&mut size)?;
    file.read_exact(&mut magic)?;
    let size = u64::from(u32::from_le_bytes(size));
    if head != *MAGIC || magic != *MAGIC || size > (length - TAIL - MAGIC.len() as u64).min(most_bytes()) {
        return Ok(None);
    }
    let start = length - TAIL - size;
    let mut bytes = Vec::new();
    file.seek(SeekFrom::Start(start))?;
    file.take(size).read_to_end(&mut bytes)?;
    Ok(Some((start, bytes)))
}

/// The footer's description of the file's columns and blocks.
pub(crate) fn metadata(footer: &[u8], options: &ParquetMetaDataOptions) -> ParquetResult<ParquetMetaData> {
    let taken = thrift::footer(footer).map_err(|found| ParquetError::General(found.to_owned()))?;
    if taken as u64 > most_bytes() {
        return Err(ParquetError::General("a footer that does not fit in memory".to_owned()));
    }
    ParquetMetaDataReader::decode_metadata_with_options(footer, Some(options))
}

/// The position of the value that follows the key `seatrial`.
fn find_envelope(footer: &[u8]) -> Option<Range<usize>> {
    let mut key = vec![STRING_FIELD, KEY.len() as u8];
    key.extend(KEY.as_bytes());
    key.push(STRING_FIELD);
    let mut at = key.len() + footer.windows(key.len()).position(|window| window == key)?;
    let mut length: usize = 0;
    for shift in (0..35).step_by(7) {
        let byte = *footer.get(at)?;
        at += 1;
        length |= usize::from(byte & 0x7f) << shift;
        if byte & 0x80 == 0 {
            let end = at.checked_add(length).filter(|&end| end <= footer.len())?;
            return Some(at..end);
        }
    }
    None
}
