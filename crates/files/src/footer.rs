//! The footer of a Parquet file as bytes: finding the envelope before anything is decoded.
//!
//! The seal is checked before the parquet crate sees the file, so the envelope is found by the bytes that
//! precede it in the compact Thrift encoding of a key and its value. The rest is validated before the parquet
//! crate reads it: that crate reserves memory for as many entries as the file announces, and recurses as deep.

use std::io::{Read, Seek, SeekFrom};
use std::ops::Range;
use std::path::Path;

use parquet::errors::Result as ParquetResult;
use parquet::file::metadata::{ParquetMetaData, ParquetMetaDataOptions, ParquetMetaDataReader};

use crate::budget::budget;
use crate::error::{Error, Result};
use crate::layout::{KEY, general};
use crate::seal::{self, Digest};

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
            let metadata = format!("no `{KEY}` metadata");
            Error::refuse(path, "file", metadata, "a table with schema and units", remedy)
        })?;
        Ok(Self { bytes, start, envelope })
    }

    /// The JSON text of the envelope.
    pub fn envelope(&self, path: &Path) -> Result<&str> {
        std::str::from_utf8(&self.bytes[self.envelope.clone()]).map_err(|_| {
            let text = "a text that is not UTF-8";
            Error::refuse(path, "metadata", text, "JSON", "the file is damaged: write it again")
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
    let taken = check_footer(footer).map_err(general)?;
    if taken as u64 > most_bytes() {
        return Err(general("a footer that does not fit in memory"));
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

/// Share of the memory that a page may take.
const SHARE: f64 = 0.25;
/// Types of the compact protocol.
const LIST: u8 = 9;
const STRUCT: u8 = 12;
/// Greatest depth of nested structs and columns.
const DEEPEST: usize = 32;
/// Approximate memory of a struct of a footer \[bytes\].
const STRUCT_BYTES: usize = 128;

/// The fault of malformed bytes.
pub(crate) const BROKEN: &str = "lengths that do not fit its bytes";

/// The sizes in the header of a page.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct PageSizes {
    /// Bytes of the page after decompression.
    pub uncompressed: i64,
    /// Values of a page of labels; 0 for other pages.
    pub labels: i64,
    /// Uncompressed bytes that come first: levels, in the second version of pages.
    pub levels: i64,
}

/// Most bytes of a page, and of a footer.
pub(crate) fn most_bytes() -> u64 {
    (SHARE * budget().bytes()) as u64
}

/// Checks the footer of a file: lists must be as long as announced, and columns nested no deeper than
/// programs do. Returns the approximate memory of its contents \[bytes\].
fn check_footer(bytes: &[u8]) -> Result<usize, &'static str> {
    let mut compact = Compact { bytes, taken: bytes.len() };
    let mut children = Vec::new();
    let mut id = 0;
    while let Some(kind) = compact.field(&mut id).ok_or(BROKEN)? {
        if (id, kind) == (2, LIST) {
            let (count, _) = compact.list().ok_or(BROKEN)?;
            for _ in 0..count {
                let mut count = 0;
                compact
                    .structure(1, &mut |id, value| {
                        if id == 5 {
                            count = count.max(value);
                        }
                    })
                    .ok_or(BROKEN)?;
                children.push(count);
            }
        } else {
            compact.value(kind, 1).ok_or(BROKEN)?;
        }
    }
    nested(&children)?;
    Ok(compact.taken)
}

/// Checks the nesting depth of columns: each struct is followed by as many children as it announces.
fn nested(children: &[i64]) -> Result<(), &'static str> {
    let mut open: Vec<i64> = Vec::new();
    for count in children {
        if *count < 0 || *count > children.len() as i64 {
            return Err(BROKEN);
        }
        if let Some(left) = open.last_mut() {
            *left -= 1;
        }
        open.push(*count);
        if open.len() > DEEPEST {
            return Err("columns nested without end");
        }
        while open.last() == Some(&0) {
            open.pop();
        }
    }
    Ok(())
}

/// The sizes in the header of a page; `None` if `bytes` end before the header does.
pub(crate) fn page_sizes(bytes: &[u8]) -> Option<PageSizes> {
    let mut compact = Compact { bytes, taken: 0 };
    let mut sizes = PageSizes::default();
    let mut id = 0;
    while let Some(kind) = compact.field(&mut id)? {
        if (id, kind) == (7, STRUCT) {
            compact.structure(1, &mut |id, value| {
                if id == 1 {
                    sizes.labels = sizes.labels.max(value);
                }
            })?;
        } else if (id, kind) == (8, STRUCT) {
            compact.structure(1, &mut |id, value| {
                if matches!(id, 5 | 6) {
                    sizes.levels = sizes.levels.saturating_add(value);
                }
            })?;
        } else if let (2, Some(value)) = (id, compact.value(kind, 1)?) {
            sizes.uncompressed = sizes.uncompressed.max(value);
        }
    }
    Some(sizes)
}

/// Bytes in the compact protocol; those already read are cut off.
struct Compact<'a> {
    bytes: &'a [u8],
    /// Memory for the entries so far.
    taken: usize,
}

impl Compact<'_> {
    fn byte(&mut self) -> Option<u8> {
        self.bytes.split_off_first().copied()
    }

    fn number(&mut self) -> Option<u64> {
        let mut number = 0;
        for shift in (0..64).step_by(7) {
            let byte = self.byte()?;
            number |= u64::from(byte & 0x7f) << shift;
            if byte & 0x80 == 0 {
                return Some(number);
            }
        }
        None
    }

    fn signed(&mut self) -> Option<i64> {
        let number = self.number()?;
        Some((number >> 1) as i64 ^ -((number & 1) as i64))
    }

    fn skip(&mut self, bytes: u64) -> Option<()> {
        self.bytes.split_off(..usize::try_from(bytes).ok()?).map(drop)
    }

    /// The type of the next field, whose number replaces the previous one; `None` at the end of a struct.
    fn field(&mut self, id: &mut i64) -> Option<Option<u8>> {
        let header = self.byte()?;
        if header == 0 {
            return Some(None);
        }
        *id = match header >> 4 {
            0 => self.signed()?,
            further => *id + i64::from(further),
        };
        Some(Some(header & 0x0f))
    }

    /// Length and type of a list, each of whose entries has at least one byte.
    fn list(&mut self) -> Option<(usize, u8)> {
        let header = self.byte()?;
        let count = match header >> 4 {
            15 => usize::try_from(self.number()?).ok()?,
            few => usize::from(few),
        };
        if count > self.bytes.len() {
            return None;
        }
        let each = if header & 0x0f == STRUCT { STRUCT_BYTES } else { size_of::<u64>() };
        self.taken = self.taken.saturating_add(count.saturating_mul(each));
        Some((count, header & 0x0f))
    }

    /// Traverses a struct; passes the numbers of integer fields and the integers to `each`.
    fn structure(&mut self, depth: usize, each: &mut dyn FnMut(i64, i64)) -> Option<()> {
        let mut id = 0;
        while let Some(kind) = self.field(&mut id)? {
            if let Some(value) = self.value(kind, depth + 1)? {
                each(id, value);
            }
        }
        Some(())
    }

    /// Traverses a value; returns it if it is an integer.
    #[expect(
        clippy::option_option,
        reason = "bytes that end, and a value that is no integer, are two things"
    )]
    fn value(&mut self, kind: u8, depth: usize) -> Option<Option<i64>> {
        if depth > DEEPEST {
            return None;
        }
        match kind {
            1 | 2 => {}
            3 => self.skip(1)?,
            4..=6 => return Some(Some(self.signed()?)),
            7 => self.skip(8)?,
            8 => {
                let length = self.number()?;
                self.skip(length)?;
            }
            LIST | 10 => {
                let (count, kind) = self.list()?;
                for _ in 0..count {
                    self.entry(kind, depth + 1)?;
                }
            }
            11 => self.map(depth)?,
            STRUCT => self.structure(depth, &mut |_, _| {})?,
            _ => return None,
        }
        Some(None)
    }

    fn map(&mut self, depth: usize) -> Option<()> {
        let count = self.number()?;
        let kinds = if count > 0 { self.byte()? } else { 0 };
        for _ in 0..count {
            self.entry(kinds >> 4, depth + 1)?;
            self.entry(kinds & 0x0f, depth + 1)?;
        }
        Some(())
    }

    /// Traverses a value in a list, where Booleans have a byte of their own.
    fn entry(&mut self, kind: u8, depth: usize) -> Option<()> {
        if matches!(kind, 1 | 2) { self.skip(1) } else { self.value(kind, depth).map(drop) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_page_header_has_its_sizes_between_other_fields() {
        // type 2, 300 bytes, 20 compressed, checksum, a page of 7 labels in encoding 0.
        let header = [0x15, 4, 0x15, 0xd8, 4, 0x15, 40, 0x15, 2, 0x3c, 0x15, 14, 0x15, 0, 0, 0];
        assert_eq!(page_sizes(&header), Some(PageSizes { uncompressed: 300, labels: 7, levels: 0 }));
        for end in 0..header.len() - 1 {
            assert_eq!(page_sizes(&header[..end]), None, "{end}");
        }
        // A text of 2^63 bytes.
        assert_eq!(page_sizes(&[0x18, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0x7f, 0]), None);
    }

    #[test]
    fn lists_that_lie_and_columns_without_depth_are_refused() {
        // Row groups: a list of 2^31 - 1 structs.
        assert_eq!(check_footer(&[0x49, 0xfc, 0xff, 0xff, 0xff, 0xff, 7, 0, 0]), Err(BROKEN));
        let nest = |depth: u8| {
            let elements = (0..depth).flat_map(|_| [0x55, 2, 0]);
            [0x29, 0xfc, depth].into_iter().chain(elements).chain([0]).collect::<Vec<u8>>()
        };
        assert!(check_footer(&nest(20)).is_ok());
        assert_eq!(check_footer(&nest(100)), Err("columns nested without end"));
    }
}
