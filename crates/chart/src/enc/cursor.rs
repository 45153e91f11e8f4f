//! Consecutive subfields, as S-57 writes them: little-endian numbers, and text up to its terminator.

use crate::enc::Invalid;
use crate::enc::iso8211::{FIELD_END, Record, UNIT_END};

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
        let Some((own, rest)) = self.rest.split_at_checked(length) else { return Err(self.early()) };
        self.rest = rest;
        Ok(latin(own))
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
