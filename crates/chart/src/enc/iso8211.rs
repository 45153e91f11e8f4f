//! Records of ISO 8211: a leader, a directory of fields, their bytes.

use crate::enc::Invalid;

/// Ends a field, and the directory.
const FIELD_END: u8 = 0x1e;
/// Ends a subfield of text.
pub(crate) const UNIT_END: u8 = 0x1f;
const LEADER: usize = 24;

/// One record: tags of four characters and the bytes of their fields, terminators included.
pub(crate) struct Record<'a> {
    /// Index in the file, from 0: the data descriptive record.
    pub number: usize,
    fields: Vec<(&'a [u8], &'a [u8])>,
}

impl<'a> Record<'a> {
    /// The bytes of the first field of a tag.
    pub(crate) fn field(&self, tag: &str) -> Option<&'a [u8]> {
        self.fields.iter().find(|(known, _)| *known == tag.as_bytes()).map(|(_, bytes)| *bytes)
    }
}

/// All records of a file: the data descriptive record, then data records.
pub(crate) fn records(file: &[u8]) -> Result<Vec<Record<'_>>, Invalid> {
    first_records(file, usize::MAX)
}

/// The first `most` records of a file, or all if there are fewer.
pub(crate) fn first_records(file: &[u8], most: usize) -> Result<Vec<Record<'_>>, Invalid> {
    let mut records = Vec::new();
    let mut at = 0;
    while at < file.len() && records.len() < most {
        let (record, length) = record(&file[at..], records.len(), at)?;
        records.push(record);
        at += length;
    }
    match records.is_empty() {
        true => Err(no_leader("an empty file")),
        false => Ok(records),
    }
}

/// The record at the beginning of `rest`, and its length.
fn record(rest: &[u8], number: usize, at: usize) -> Result<(Record<'_>, usize), Invalid> {
    let leader = Leader::read(rest, number).ok_or_else(|| match (number, rest.len() < LEADER) {
        (0, _) => no_leader("none at its beginning"),
        (_, true) => cut(number, at, format!("{} bytes of a leader", rest.len())),
        (_, false) => cut(number, at, "no leader".to_owned()),
    })?;
    let whole = |to: usize| {
        rest.get(..to).ok_or_else(|| {
            cut(number, at, format!("{} of at least {to} bytes: the file is cut off", rest.len()))
        })
    };
    let directory = whole(leader.base)?.get(LEADER..).unwrap_or_default();
    let broken = || cut(number, at, "a directory that leads out of the record".to_owned());
    let entries = directory.strip_suffix(&[FIELD_END]).ok_or_else(broken)?;
    let width = 4 + leader.length_digits + leader.place_digits;
    let mut fields = Vec::with_capacity(entries.len() / width);
    let mut end = leader.base;
    for entry in entries.chunks(width) {
        let (length, place) = leader.entry(entry).ok_or_else(broken)?;
        let from = leader.base + place;
        end = end.max(from + length);
        let to = from + length;
        if leader.length > 0 && to > leader.length {
            return Err(broken());
        }
        fields.push((&entry[..4], &whole(to)?[from..]));
    }
    // Records of 100,000 bytes and more do not state their length.
    let length = if leader.length > 0 { leader.length } else { end };
    whole(length)?;
    Ok((Record { number, fields }, length))
}

/// The leader at the beginning of a record.
struct Leader {
    length: usize,
    /// Where the fields begin.
    base: usize,
    length_digits: usize,
    place_digits: usize,
}

impl Leader {
    /// `None` where there is none of the right kind: the first record is descriptive, all others are data.
    fn read(rest: &[u8], number: usize) -> Option<Self> {
        let leader = rest.get(..LEADER)?;
        let kind = if number == 0 { b'L' } else { b'D' };
        let digit = |k: usize| decimal(&leader[k..=k]);
        let parsed = Self {
            length: decimal(&leader[..5])?,
            base: decimal(&leader[12..17])?,
            length_digits: digit(20)?,
            place_digits: digit(21)?,
        };
        let sound = leader[6] == kind && digit(23) == Some(4) && parsed.base > LEADER;
        sound.then_some(parsed)
    }

    /// Length and offset of a field, from its entry in the directory.
    fn entry(&self, entry: &[u8]) -> Option<(usize, usize)> {
        let length = decimal(entry.get(4..4 + self.length_digits)?)?;
        let place = decimal(entry.get(4 + self.length_digits..4 + self.length_digits + self.place_digits)?)?;
        Some((length, place))
    }
}

fn decimal(digits: &[u8]) -> Option<usize> {
    let digits = std::str::from_utf8(digits).ok()?;
    digits.bytes().all(|b| b.is_ascii_digit()).then(|| digits.parse().ok())?
}

fn no_leader(found: &str) -> Invalid {
    Invalid::new(
        "leader of ISO 8211",
        format!("{found} (encrypted by S-63, compressed, or no chart)"),
        "a cell of an electronic chart (S-57) that is not encrypted",
        "decrypt it with the permit of its data server, or take the producer's open cell",
    )
}

fn cut(number: usize, at: usize, found: String) -> Invalid {
    let thing = format!("record {number} at byte {at}");
    Invalid::new(thing, found, "a whole record of ISO 8211", "download or copy the file again")
}

/// The encoding of text (S-57, 2.4: lexical levels 0 and 1 are single-byte Latin letters, 2 is UCS-2).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Lexical {
    Latin,
    Ucs2,
}

/// The unread rest of a field.
pub(crate) struct Cursor<'a> {
    rest: &'a [u8],
    tag: &'static str,
    record: usize,
}

impl<'a> Cursor<'a> {
    /// The field of a tag, without its terminator; `None` where the record lacks it.
    pub(crate) fn of(record: &Record<'a>, tag: &'static str) -> Option<Self> {
        Self::of_text(record, tag, Lexical::Latin)
    }

    /// The same for a field whose text and terminator are encoded as `lexical`.
    pub(crate) fn of_text(record: &Record<'a>, tag: &'static str, lexical: Lexical) -> Option<Self> {
        let bytes = record.field(tag)?;
        let end: &[u8] = if lexical == Lexical::Ucs2 { &[FIELD_END, 0] } else { &[FIELD_END] };
        let rest = bytes.strip_suffix(end).or_else(|| bytes.strip_suffix(&[FIELD_END])).unwrap_or(bytes);
        Some(Self { rest, tag, record: record.number })
    }

    /// A mandatory field.
    pub(crate) fn needed(record: &Record<'a>, tag: &'static str) -> Result<Self, Invalid> {
        Self::of(record, tag).ok_or_else(|| {
            let thing = format!("record {}", record.number);
            Invalid::new(thing, format!("no field {tag}"), tag, "download or copy the file again")
        })
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.rest.is_empty()
    }

    fn take<const N: usize>(&mut self) -> Result<[u8; N], Invalid> {
        let Some((head, rest)) = self.rest.split_first_chunk::<N>() else { return Err(self.early()) };
        self.rest = rest;
        Ok(*head)
    }

    pub(crate) fn u8(&mut self) -> Result<u8, Invalid> {
        Ok(self.take::<1>()?[0])
    }

    pub(crate) fn u16(&mut self) -> Result<u16, Invalid> {
        Ok(u16::from_le_bytes(self.take()?))
    }

    pub(crate) fn u32(&mut self) -> Result<u32, Invalid> {
        Ok(u32::from_le_bytes(self.take()?))
    }

    pub(crate) fn i32(&mut self) -> Result<i32, Invalid> {
        Ok(i32::from_le_bytes(self.take()?))
    }

    /// A text of fixed length.
    pub(crate) fn letters<const N: usize>(&mut self) -> Result<String, Invalid> {
        Ok(self.take::<N>()?.iter().map(|b| char::from(*b)).collect())
    }

    /// A text of a fixed length, or up to its terminator, which the last one of a field may lack.
    pub(crate) fn text_of(&mut self, length: Option<usize>) -> Result<String, Invalid> {
        let Some(length) = length else {
            let ends = self.rest.contains(&UNIT_END);
            return if ends { self.text(Lexical::Latin) } else { Ok(latin(std::mem::take(&mut self.rest))) };
        };
        let Some((value, rest)) = self.rest.split_at_checked(length) else { return Err(self.early()) };
        self.rest = rest;
        Ok(latin(value))
    }

    /// A text up to its terminator.
    pub(crate) fn text(&mut self, lexical: Lexical) -> Result<String, Invalid> {
        match lexical {
            Lexical::Latin => {
                let Some(end) = self.rest.iter().position(|b| *b == UNIT_END) else {
                    return Err(self.early());
                };
                let text = latin(&self.rest[..end]);
                self.rest = &self.rest[end + 1..];
                Ok(text)
            }
            Lexical::Ucs2 => {
                let (pairs, _) = self.rest.as_chunks::<2>();
                let end = pairs.iter().position(|pair| *pair == [UNIT_END, 0]);
                let Some(end) = end else { return Err(self.early()) };
                let letters: Vec<u16> = pairs[..end].iter().map(|pair| u16::from_le_bytes(*pair)).collect();
                self.rest = &self.rest[2 * end + 2..];
                Ok(String::from_utf16_lossy(&letters))
            }
        }
    }

    fn early(&self) -> Invalid {
        Invalid::new(
            format!("record {}, field {}", self.record, self.tag),
            "an end within a subfield",
            "whole subfields",
            "download or copy the file again",
        )
    }
}

fn latin(bytes: &[u8]) -> String {
    bytes.iter().map(|b| char::from(*b)).collect()
}

// Checks the data descriptive record against the fields of S-57 (3.1, part 3, 7.3, binary).

/// Fields that are read, and their layout: `b12` an unsigned number of two bytes, `b24` a signed one of four,
/// `B(40)` forty bits, `A` text.
const FIELDS: [(&str, &str); 16] = [
    ("DSID", "b11,b14,2b11,3A,2A(8),R(4),b11,2A,b11,b12,A"),
    ("DSSI", "3b11,8b14"),
    ("DSPM", "b11,b14,3b11,b14,4b11,2b14,A"),
    ("VRID", "b11,b14,b12,b11"),
    ("ATTV", "b12,A"),
    ("VRPC", "b11,2b12"),
    ("VRPT", "B(40),4b11"),
    ("SGCC", "b11,2b12"),
    ("SG2D", "2b24"),
    ("SG3D", "3b24"),
    ("FRID", "b11,b14,2b11,2b12,b11"),
    ("FOID", "b12,b14,b12"),
    ("ATTF", "b12,A"),
    ("NATF", "b12,A"),
    ("FSPC", "b11,2b12"),
    ("FSPT", "B(40),3b11"),
];
/// Fields that only other products have.
const OTHERS: [(&[u8], &str); 3] =
    [(b"CATD", "a catalogue of an exchange set"), (b"ATCS", "S-101"), (b"CSID", "S-101")];

/// Refuses files of another product, and fields with another layout.
pub(crate) fn check(descriptive: &Record<'_>) -> Result<(), Invalid> {
    for (tag, product) in OTHERS {
        if descriptive.fields.iter().any(|(known, _)| *known == tag) {
            return Err(other_product(product));
        }
    }
    if descriptive.field("DSID").is_none() {
        return Err(other_product("ISO 8211 without the field DSID"));
    }
    for (tag, expected) in FIELDS {
        let Some(described) = descriptive.field(tag) else { continue };
        let layout = format_of(described);
        if expanded(&layout) != expanded(expected) {
            let remedy = "take the binary form of the cell (S-57, implementation `b`)";
            return Err(Invalid::new(
                format!("field {tag}"),
                format!("`{layout}`"),
                format!("`({expected})`"),
                remedy,
            ));
        }
    }
    Ok(())
}

pub(crate) fn other_product(found: &str) -> Invalid {
    Invalid::new(
        "product",
        found,
        "a cell of an electronic chart by S-57 (ENC)",
        "take the S-57 cell (`.000`) of the same waters",
    )
}

/// The format at the end of a field's description.
pub(crate) fn format_of(described: &[u8]) -> String {
    let last = described.rsplit(|b| *b == UNIT_END).next().unwrap_or_default();
    last.iter().filter(|b| **b != FIELD_END).map(|b| char::from(*b)).collect()
}

/// The codes of a format, one per subfield: `(b11,2b12)` is b11, b12, b12.
pub(crate) fn expanded(format: &str) -> Vec<String> {
    let inside = format.strip_prefix('(').and_then(|f| f.strip_suffix(')')).unwrap_or(format);
    inside.split(',').flat_map(repeated).collect()
}

fn repeated(part: &str) -> impl Iterator<Item = String> {
    let digits = part.bytes().take_while(u8::is_ascii_digit).count();
    let (count, code) = part.split_at(digits);
    // No field of the table has more subfields.
    let count = count.parse().unwrap_or(1_usize).min(64);
    std::iter::repeat_n(code.to_owned(), count)
}
