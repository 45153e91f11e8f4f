//! The lines of a text.

use std::io::{BufRead, Read};

use refusal::Invalid;

use crate::LogError;
use crate::encoding::{Plain, plain};

/// A line of more bytes is not taken for text.
const LONGEST_LINE: u64 = 1 << 20;

/// The lines of a text, one at a time.
pub(crate) struct Lines<'a> {
    text: Plain<'a>,
    line: Vec<u8>,
    /// Number of the line, from 1.
    pub(crate) number: usize,
    /// Whether the line is terminated: the last one may be cut.
    pub(crate) is_ended: bool,
    /// Roughly how many bytes of the file all lines so far took.
    pub(crate) read: u64,
}

impl<'a> Lines<'a> {
    /// The lines of text in any encoding.
    ///
    /// # Errors
    /// Bytes that cannot be read.
    pub(crate) fn new(bytes: impl BufRead + 'a) -> Result<Self, LogError> {
        Ok(Self { text: plain(bytes)?, line: Vec::new(), number: 0, is_ended: true, read: 0 })
    }

    /// The next line, without its end.
    pub(crate) fn next(&mut self) -> Result<Option<&str>, LogError> {
        let Some((number, line)) = self.bytes()? else { return Ok(None) };
        std::str::from_utf8(line).map(Some).map_err(|_| {
            let found = format!("a byte that is not UTF-8 (line {number})");
            LogError::Invalid(Invalid::new("text", found, "UTF-8 text", "save the file as UTF-8"))
        })
    }

    /// The number of the next line, from 1, and its bytes, without its end.
    pub(crate) fn bytes(&mut self) -> Result<Option<(usize, &[u8])>, LogError> {
        self.line.clear();
        if (&mut self.text.text).take(LONGEST_LINE).read_until(b'\n', &mut self.line)? == 0 {
            return Ok(None);
        }
        self.number += 1;
        self.read += self.text.width * self.line.len() as u64;
        if self.line.len() as u64 == LONGEST_LINE {
            return Err(LogError::Invalid(Invalid::new(
                format!("line {}", self.number),
                format!("{LONGEST_LINE} bytes without an end of the line"),
                "a row of cells",
                "correct or leave out the file: it is damaged, or not CSV",
            )));
        }
        self.is_ended = self.line.ends_with(b"\n");
        let line = self.line.strip_suffix(b"\n").unwrap_or(&self.line);
        Ok(Some((self.number, line.strip_suffix(b"\r").unwrap_or(line))))
    }
}
