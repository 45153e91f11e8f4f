//! Tables of an SQLite file, read row by row. Pages and lengths are not trusted. <https://www.sqlite.org/fileformat2.html>

use std::io::{ErrorKind, Read, Seek, SeekFrom};

use refusal::Invalid;

use crate::BagError;
use crate::chunks::LARGEST;
use crate::varint::varint;

const MAGIC: &[u8; 16] = b"SQLite format 3\0";

/// Depth of a tree beyond which it is damaged: pages hold hundreds of branches.
const DEEPEST: usize = 20;

/// The remedy for damage.
pub(crate) const COPY: &str =
    "the file is truncated or damaged: copy it again, or mend it with `sqlite3 FILE '.recover'`";

/// A value of a row.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Value {
    Null,
    Integer(i64),
    Real,
    Text(String),
    Bytes(Vec<u8>),
}

/// A file of tables.
pub(crate) struct Database<'a, F> {
    file: &'a mut F,
    page_size: usize,
    /// Bytes of a page without those that are reserved at its end.
    usable: usize,
    pages: u32,
}

impl<'a, F: Read + Seek> Database<'a, F> {
    /// Opens a file.
    ///
    /// # Errors
    /// Bytes that cannot be read, are not a database in UTF-8, or fewer than it says.
    pub(crate) fn open(file: &'a mut F) -> Result<Self, BagError> {
        let mut head = [0; 100];
        let length = file.seek(SeekFrom::End(0))?;
        file.seek(SeekFrom::Start(0))?;
        file.read_exact(&mut head).map_err(short)?;
        let number = |at: usize| u32::from_be_bytes([head[at], head[at + 1], head[at + 2], head[at + 3]]);
        let page_size = match u16::from_be_bytes([head[16], head[17]]) {
            1 => 1 << 16,
            size => usize::from(size),
        };
        let usable = page_size.saturating_sub(usize::from(head[20]));
        let is_known = page_size.is_power_of_two() && usable >= 480 && number(56) <= 1;
        if head[..16] != *MAGIC || !is_known {
            return Err(damaged("a header that is not known").into());
        }
        let held = length / page_size as u64;
        // The count is valid where the file was last written by a version that knows of it.
        let stated = if number(24) == number(92) { number(28) } else { 0 };
        if held < u64::from(stated) {
            return Err(damaged(&format!("{held} of {stated} pages")).into());
        }
        let pages = u32::try_from(held).unwrap_or(u32::MAX);
        Ok(Self { file, page_size, usable, pages })
    }

    /// Passes each row of the table whose tree begins at page `root` to `each`: its number, and its values. `wants` sees
    /// the values without the last one and says whether the row is read.
    ///
    /// # Errors
    /// Damage; refusals of `each`.
    pub(crate) fn rows(
        &mut self,
        root: u32,
        wants: &dyn Fn(&[Value]) -> bool,
        each: &mut dyn FnMut(i64, Vec<Value>) -> Result<(), BagError>,
    ) -> Result<(), BagError> {
        let mut visited = 0;
        let mut open = vec![(root, 0)];
        while let Some((number, depth)) = open.pop() {
            visited += 1;
            if visited > self.pages || depth > DEEPEST {
                return Err(damaged("a tree of pages that does not end").into());
            }
            let page = self.page(number)?;
            // The first page begins with the file's header.
            let start = if number == 1 { 100 } else { 0 };
            let kind = page[start];
            let cells = usize::from(u16_at(&page, start + 3).ok_or_else(wrong)?);
            let pointers = start + if kind == INTERIOR { 12 } else { 8 };
            let cell = |i: usize| u16_at(&page, pointers + 2 * i).map(usize::from).ok_or_else(wrong);
            match kind {
                INTERIOR => {
                    open.push((u32_at(&page, start + 8).ok_or_else(wrong)?, depth + 1));
                    for i in (0..cells).rev() {
                        open.push((u32_at(&page, cell(i)?).ok_or_else(wrong)?, depth + 1));
                    }
                }
                LEAF => {
                    for i in 0..cells {
                        if let Some((row, values)) = self.row(&page, cell(i)?, wants)? {
                            each(row, values)?;
                        }
                    }
                }
                _ => return Err(wrong().into()),
            }
        }
        Ok(())
    }

    fn page(&mut self, number: u32) -> Result<Vec<u8>, BagError> {
        if !(1..=self.pages).contains(&number) {
            return Err(damaged(&format!("page {number} of {}", self.pages)).into());
        }
        let mut page = vec![0; self.page_size];
        self.file.seek(SeekFrom::Start(u64::from(number - 1) * self.page_size as u64))?;
        self.file.read_exact(&mut page).map_err(short)?;
        Ok(page)
    }

    /// The row of the cell at `at`, if it is wanted.
    fn row(
        &mut self,
        page: &[u8],
        at: usize,
        wants: &dyn Fn(&[Value]) -> bool,
    ) -> Result<Option<(i64, Vec<Value>)>, BagError> {
        let mut rest = page.get(at..self.usable).ok_or_else(wrong)?;
        let size = varint(&mut rest).and_then(|size| usize::try_from(size).ok()).ok_or_else(wrong)?;
        let row = varint(&mut rest).ok_or_else(wrong)?;
        let local = self.local(size);
        let mut payload = rest.get(..local).ok_or_else(wrong)?.to_vec();
        // What a row begins with stands on its own page.
        let Some(types) = types(&payload) else { return Err(wrong().into()) };
        let first = values(&payload, &types[..types.len().saturating_sub(1)]);
        if first.is_some_and(|first| !wants(&first)) {
            return Ok(None);
        }
        if size > LARGEST {
            return Err(damaged(&format!("a row of {size} bytes")).into());
        }
        let mut next = if local < size { u32_at(rest, local).ok_or_else(wrong)? } else { 0 };
        while payload.len() < size {
            let page = self.page(next)?;
            next = u32_at(&page, 0).ok_or_else(wrong)?;
            let more = (size - payload.len()).min(self.usable - 4);
            payload.extend_from_slice(&page[4..4 + more]);
        }
        let values = values(&payload, &types).ok_or_else(wrong)?;
        Ok(Some((row, values)))
    }

    /// How many bytes of a row of `size` stand on its own page.
    fn local(&self, size: usize) -> usize {
        let most = self.usable - 35;
        let least = (self.usable - 12) * 32 / 255 - 23;
        let filled = least + size.saturating_sub(least) % (self.usable - 4);
        match size {
            size if size <= most => size,
            _ if filled <= most => filled,
            _ => least,
        }
    }
}

/// Kinds of pages.
const INTERIOR: u8 = 5;
const LEAF: u8 = 13;

/// The types of a row's values, and where the values begin.
fn types(payload: &[u8]) -> Option<Vec<(u64, usize)>> {
    let mut rest = payload;
    let header = usize::try_from(varint(&mut rest)?).ok()?;
    let before = payload.len() - rest.len();
    let mut rest = payload.get(before..header)?;
    let (mut types, mut at) = (Vec::new(), header);
    while !rest.is_empty() {
        let kind = u64::try_from(varint(&mut rest)?).ok()?;
        types.push((kind, at));
        at = at.checked_add(length(kind)?)?;
    }
    Some(types)
}

/// Bytes of a value.
fn length(kind: u64) -> Option<usize> {
    Some(match kind {
        0 | 8 | 9 => 0,
        1..=4 => kind as usize,
        5 => 6,
        6 | 7 => 8,
        10 | 11 => return None,
        _ => usize::try_from((kind - 12) / 2).ok()?,
    })
}

/// The values of `types` in a row; `None` where it ends before them.
fn values(payload: &[u8], types: &[(u64, usize)]) -> Option<Vec<Value>> {
    let value = |(kind, at): &(u64, usize)| {
        let bytes = payload.get(*at..at.checked_add(length(*kind)?)?)?;
        Some(match kind {
            0 => Value::Null,
            8 | 9 => Value::Integer(*kind as i64 - 8),
            1..=6 => {
                let sign = if bytes[0] & 0x80 == 0 { 0 } else { -1 };
                Value::Integer(bytes.iter().fold(sign, |all, byte| (all << 8) | i64::from(*byte)))
            }
            7 => Value::Real,
            kind if kind % 2 == 1 => Value::Text(String::from_utf8_lossy(bytes).into_owned()),
            _ => Value::Bytes(bytes.to_vec()),
        })
    };
    types.iter().map(value).collect()
}

fn u16_at(bytes: &[u8], at: usize) -> Option<u16> {
    Some(u16::from_be_bytes(*bytes.get(at..)?.first_chunk()?))
}

fn u32_at(bytes: &[u8], at: usize) -> Option<u32> {
    Some(u32::from_be_bytes(*bytes.get(at..)?.first_chunk()?))
}

fn short(error: std::io::Error) -> BagError {
    match error.kind() {
        ErrorKind::UnexpectedEof => damaged("an end within a page").into(),
        _ => error.into(),
    }
}

fn wrong() -> Invalid {
    damaged("a page that cannot be read")
}

fn damaged(found: &str) -> Invalid {
    Invalid::new("file", found, "a whole SQLite database", COPY)
}
