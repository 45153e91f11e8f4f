//! Text in UTF-8 or UTF-16, with any line endings: read as UTF-8 whose lines end with ` ` or `\r `.
//!
//! Text that already has this form passes through unchanged. The first bytes decide, and are held back only until then.

use std::io::{self, BufRead, Cursor, Read};

use refusal::Invalid;

/// Bytes that are inspected to recognize an encoding.
const PROBE: usize = 1 << 16;

/// Bytes by which UTF-16 without a byte order mark is recognized.
const PATTERN: usize = 256;

/// A text, and roughly how many bytes of the file each of its bytes takes.
struct Plain<'a> {
    pub(crate) text: Box<dyn BufRead + 'a>,
    pub(crate) width: u64,
}

/// A character encoding.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Encoding {
    Utf8,
    Utf16 { is_big: bool },
}

/// Decodes `bytes` as text.
fn plain<'a>(bytes: impl BufRead + 'a) -> io::Result<Plain<'a>> {
    let (head, bytes) = probed(bytes)?;
    let (encoding, mark) = encoding(&head);
    let Encoding::Utf16 { is_big } = encoding else {
        return Ok(Plain { text: with_plain_ends(head, mark, bytes), width: 1 });
    };
    let mut bytes = Cursor::new(head).chain(bytes);
    bytes.consume(mark);
    let (head, text) = probed(Converted::new(bytes, Utf16 { is_big, byte: None, high: None }))?;
    Ok(Plain { text: with_plain_ends(head, 0, text), width: 2 })
}

/// The first bytes, and a reader of the rest.
fn probed<R: BufRead>(mut bytes: R) -> io::Result<(Vec<u8>, R)> {
    let mut head = Vec::with_capacity(PROBE);
    bytes.by_ref().take(PROBE as u64).read_to_end(&mut head)?;
    Ok((head, bytes))
}

/// By a byte order mark, whose length comes second, or by zeros at every second byte.
fn encoding(head: &[u8]) -> (Encoding, usize) {
    let marks: [(&[u8], Encoding); 3] = [
        (b"\xEF\xBB\xBF", Encoding::Utf8),
        (b"\xFF\xFE", Encoding::Utf16 { is_big: false }),
        (b"\xFE\xFF", Encoding::Utf16 { is_big: true }),
    ];
    if let Some((mark, encoding)) = marks.into_iter().find(|(mark, _)| head.starts_with(mark)) {
        return (encoding, mark.len());
    }
    let (pairs, _) = head[..head.len().min(PATTERN)].as_chunks::<2>();
    let zeros = |place: usize| pairs.iter().filter(|pair| pair[place] == 0).count();
    let most = |count: usize| count > 1 && 10 * count >= 9 * pairs.len();
    match [zeros(0), zeros(1)] {
        [0, high] if most(high) => (Encoding::Utf16 { is_big: false }, 0),
        [high, 0] if most(high) => (Encoding::Utf16 { is_big: true }, 0),
        _ => (Encoding::Utf8, 0),
    }
}

/// `head` from byte `start` on and then `rest`, with carriage returns that end lines on their own as `
/// `. Undecodable bytes are kept as they are.
fn with_plain_ends<'a>(head: Vec<u8>, start: usize, rest: impl BufRead + 'a) -> Box<dyn BufRead + 'a> {
    let is_odd = !head.contains(&0) && has_lone_returns(&head);
    let mut head = Cursor::new(head);
    head.consume(start);
    let text = head.chain(rest);
    if is_odd { Box::new(Converted::new(text, Ends::default())) } else { Box::new(text) }
}

/// Whether a carriage return is followed by anything but the end of its line.
fn has_lone_returns(head: &[u8]) -> bool {
    let after = head.iter().skip(1).chain([&b'\n']);
    head.iter().zip(after).any(|(byte, next)| *byte == b'\r' && !matches!(next, b'\r' | b'\n'))
        || head.len() < PROBE && head.ends_with(b"\r")
}

/// Converts text block by block.
trait Convert {
    /// Appends the conversion of `bytes` to `made`.
    fn take(&mut self, bytes: &[u8], made: &mut Vec<u8>);

    /// Appends what remains at the end.
    fn end(&mut self, made: &mut Vec<u8>);
}

/// A reader of the converted bytes of `inner`.
struct Converted<R, C> {
    inner: R,
    convert: C,
    made: Vec<u8>,
    /// How much of the converted block was read.
    at: usize,
    is_over: bool,
}

impl<R, C> Converted<R, C> {
    fn new(inner: R, convert: C) -> Self {
        Self { inner, convert, made: Vec::new(), at: 0, is_over: false }
    }
}

impl<R: BufRead, C: Convert> BufRead for Converted<R, C> {
    fn fill_buf(&mut self) -> io::Result<&[u8]> {
        while self.at == self.made.len() && !self.is_over {
            self.made.clear();
            self.at = 0;
            let bytes = self.inner.fill_buf()?;
            let length = bytes.len();
            if length == 0 {
                self.is_over = true;
                self.convert.end(&mut self.made);
            } else {
                self.convert.take(bytes, &mut self.made);
            }
            self.inner.consume(length);
        }
        Ok(&self.made[self.at..])
    }

    fn consume(&mut self, amount: usize) {
        self.at = (self.at + amount).min(self.made.len());
    }
}

impl<R: BufRead, C: Convert> Read for Converted<R, C> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let read = self.fill_buf()?.read(buffer)?;
        self.consume(read);
        Ok(read)
    }
}

/// Any line endings to ` `: carriage returns before a line feed belong to it, every other one ends a line.
#[derive(Default)]
struct Ends {
    /// Carriage returns whose meaning depends on the next byte.
    returns: usize,
}

impl Ends {
    fn put(&mut self, lines: usize, made: &mut Vec<u8>) {
        made.extend(std::iter::repeat_n(b'\n', lines));
        self.returns = 0;
    }
}

impl Convert for Ends {
    fn take(&mut self, bytes: &[u8], made: &mut Vec<u8>) {
        for byte in bytes {
            match byte {
                b'\r' => self.returns += 1,
                b'\n' => self.put(1, made),
                byte => {
                    if self.returns > 0 {
                        self.put(self.returns, made);
                    }
                    made.push(*byte);
                }
            }
        }
    }

    fn end(&mut self, made: &mut Vec<u8>) {
        self.put(self.returns, made);
    }
}

/// UTF-16 to UTF-8.
struct Utf16 {
    is_big: bool,
    /// The first byte of a pair.
    byte: Option<u8>,
    /// A high surrogate, which waits for the low one.
    high: Option<u16>,
}

impl Utf16 {
    fn unit(&mut self, unit: u16, made: &mut Vec<u8>) {
        if self.high.is_none() && (0xD800..0xDC00).contains(&unit) {
            self.high = Some(unit);
            return;
        }
        let units = self.high.take().into_iter().chain([unit]);
        for character in char::decode_utf16(units) {
            let character = character.unwrap_or(char::REPLACEMENT_CHARACTER);
            made.extend_from_slice(character.encode_utf8(&mut [0; 4]).as_bytes());
        }
    }
}

impl Convert for Utf16 {
    fn take(&mut self, bytes: &[u8], made: &mut Vec<u8>) {
        for byte in bytes {
            let Some(first) = self.byte.take() else {
                self.byte = Some(*byte);
                continue;
            };
            let pair = [first, *byte];
            let unit = if self.is_big { u16::from_be_bytes(pair) } else { u16::from_le_bytes(pair) };
            self.unit(unit, made);
        }
    }

    fn end(&mut self, made: &mut Vec<u8>) {
        if self.byte.is_some() || self.high.is_some() {
            made.extend_from_slice(char::REPLACEMENT_CHARACTER.to_string().as_bytes());
        }
    }
}

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
    pub(crate) fn new(bytes: impl BufRead + 'a) -> Result<Self, LogError> {
        Ok(Self { text: plain(bytes)?, line: Vec::new(), number: 0, is_ended: true, read: 0 })
    }

    /// The next line, without its end.
    pub(crate) fn next(&mut self) -> Result<Option<&str>, LogError> {
        let Some((number, line)) = self.bytes()? else { return Ok(None) };
        std::str::from_utf8(line).map(Some).map_err(|_| {
            let byte = format!("a byte that is not UTF-8 (line {number})");
            LogError::Invalid(Invalid::new("text", byte, "UTF-8 text", "save the file as UTF-8"))
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

/// Why bytes are not a log.
#[derive(Debug)]
pub enum LogError {
    /// They cannot be read.
    Unreadable(io::Error),
    /// They can be read, but are not a log.
    Invalid(Invalid),
}

impl From<io::Error> for LogError {
    fn from(error: io::Error) -> Self {
        Self::Unreadable(error)
    }
}

impl From<Invalid> for LogError {
    fn from(invalid: Invalid) -> Self {
        Self::Invalid(invalid)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Gives its bytes a few at a time.
    struct Few<'a>(&'a [u8]);

    impl Read for Few<'_> {
        fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
            let few = buffer.len().min(3);
            self.0.read(&mut buffer[..few])
        }
    }

    fn read(bytes: &[u8]) -> String {
        let mut text = String::new();
        let bytes = io::BufReader::with_capacity(7, Few(bytes));
        plain(bytes).unwrap().text.read_to_string(&mut text).unwrap();
        text
    }

    fn utf16(text: &str, is_big: bool) -> Vec<u8> {
        text.encode_utf16().flat_map(|u| if is_big { u.to_be_bytes() } else { u.to_le_bytes() }).collect()
    }

    #[test]
    fn law_any_encoding_and_any_ends_give_the_same_lines() {
        let text = "t,größe,𝄞\n1,2,3\n\n4,5,6\n".repeat(5000);
        for ends in ["\n", "\r", "\r\r\n"] {
            let written = text.replace('\n', ends);
            assert_eq!(read(written.as_bytes()).replace('\r', ""), text, "{ends:?}");
            assert_eq!(read(("\u{feff}".to_owned() + &written).as_bytes()).replace('\r', ""), text);
            for is_big in [false, true] {
                let marked = utf16(&("\u{feff}".to_owned() + &written), is_big);
                assert_eq!(read(&marked).replace('\r', ""), text, "{ends:?}, marked");
                assert_eq!(read(&marked[2..]).replace('\r', ""), text, "{ends:?}, without a mark");
            }
        }
        let (mut mixed, mut ends) = (String::new(), ["\r", "\n", "\r\n"].into_iter().cycle());
        text.lines().for_each(|line| mixed.extend([line, ends.next().unwrap()]));
        assert_eq!(read(mixed.as_bytes()).lines().filter(|l| !l.is_empty()).count(), 15_000);
    }

    #[test]
    fn plain_text_and_bytes_that_are_none_stay() {
        for bytes in ["", "\r", "a", "a,b\r\nc,d\r\n", "a\0\rb\n"] {
            assert_eq!(read(bytes.as_bytes()), if bytes == "\r" { "\n" } else { bytes });
        }
        assert_eq!(read(b"\xFF\xFEa\0\x00\xD8b\0c"), "a\u{fffd}b\u{fffd}");
    }
}
