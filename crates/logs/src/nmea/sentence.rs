//! Sentences: their start in a line, address, fields, checksum.

/// A sentence: `$`, an address, fields.
#[derive(Clone, Copy)]
pub(super) struct Sentence<'a> {
    /// Talker and kind: `GPRMC`.
    pub(super) address: &'a str,
    /// Between `$` and `*`.
    body: &'a str,
}

impl<'a> Sentence<'a> {
    /// Field `i`, from 0; empty where there is none.
    pub(super) fn field(&self, i: usize) -> &'a str {
        self.body.split(',').nth(i + 1).map_or("", str::trim)
    }

    /// Number of fields.
    pub(super) fn fields(&self) -> usize {
        self.body.bytes().filter(|byte| *byte == b',').count()
    }

    /// Whether its kind is `kind`; proprietary sentences, which begin with P, are of no kind.
    pub(super) fn is_a(&self, kind: &str) -> bool {
        self.address.len() == 5
            && self.address.is_ascii()
            && self.address.ends_with(kind)
            && !self.address.starts_with('P')
    }
}

/// The text from one `$` to the next.
pub(super) struct RawSentence<'a> {
    /// The text before it on the line that belongs to no other sentence.
    pub(super) prefix: &'a str,
    /// From `$` to the end of the checksum.
    text: &'a str,
    /// Whether the next sentence begins on the same line.
    pub(super) is_followed: bool,
}

/// The state of a checksum.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Checksum {
    Right,
    Wrong,
    None,
}

/// The sentences of a line: each begins with a `$`. AIS sentences, which begin with a `!`, are left out but
/// end the previous one.
pub(super) fn raw_sentences(line: &str) -> impl Iterator<Item = RawSentence<'_>> {
    let mut rest = start(line);
    let mut before = &line[..line.len() - rest.len()];
    std::iter::from_fn(move || {
        while !rest.is_empty() {
            let next = start(&rest[1..]);
            let own = &rest[..rest.len() - next.len()];
            let (text, after) = own.split_at(end(own));
            let raw = RawSentence { prefix: before, text, is_followed: !next.is_empty() };
            (rest, before) = (next, after);
            if text.starts_with('$') {
                return Some(raw);
            }
        }
        None
    })
}

/// `text` from the start of a sentence on.
fn start(text: &str) -> &str {
    let bytes = text.as_bytes();
    let begins = |i: &usize| match bytes[*i] {
        b'$' => true,
        b'!' => bytes.get(i + 1..i + 4).is_some_and(|own| own.iter().all(u8::is_ascii_uppercase)),
        _ => false,
    };
    (0..bytes.len()).find(begins).map_or("", |i| &text[i..])
}

/// The end of a sentence: after its checksum, or at the end of the text.
fn end(text: &str) -> usize {
    let checksum = text.find('*').map(|star| star + 3);
    checksum.filter(|end| text.is_char_boundary(*end) && *end <= text.len()).unwrap_or(text.len())
}

impl<'a> RawSentence<'a> {
    /// The sentence and the state of its checksum.
    pub(super) fn sentence(&self) -> (Sentence<'a>, Checksum) {
        let text = &self.text[1..];
        let (body, stated) = text.split_once('*').map_or((text, None), |(body, rest)| (body, Some(rest)));
        let address = body.split(',').next().unwrap_or_default().trim();
        let checksum = match stated {
            None => Checksum::None,
            Some(stated) if is_checksum(stated, body) => Checksum::Right,
            Some(_) => Checksum::Wrong,
        };
        (Sentence { address, body }, checksum)
    }
}

/// Whether `stated`, two hexadecimal digits, is the checksum of `body`.
fn is_checksum(stated: &str, body: &str) -> bool {
    let digits = stated.get(..2).filter(|digits| digits.bytes().all(|byte| byte.is_ascii_hexdigit()));
    let stated = digits.and_then(|digits| u8::from_str_radix(digits, 16).ok());
    stated == Some(body.bytes().fold(0, |sum, byte| sum ^ byte))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn checksums(line: &str) -> Vec<(String, bool)> {
        let own = |raw: RawSentence| {
            let (sentence, checksum) = raw.sentence();
            (sentence.address.to_owned(), checksum == Checksum::Right)
        };
        raw_sentences(line).map(own).collect()
    }

    #[test]
    fn published_sentences_have_right_checksums() {
        // Of the documentation of gpsd.
        for text in [
            "$GPGGA,123519,4807.038,N,01131.324,E,1,08,0.9,545.4,M,46.9,M, , *42",
            "$GPRMC,225446,A,4916.45,N,12311.12,W,000.5,054.7,191194,020.3,E*68",
            "$GPVTG,220.86,T,,M,2.550,N,4.724,K,A*34",
        ] {
            let right =
                |text: &str| checksums(text).iter().all(|(address, right)| address.len() == 5 && *right);
            assert!(
                right(text)
                    && right(
                        &text
                            .to_lowercase()
                            .replace(&text.to_lowercase()[..text.len() - 2], &text[..text.len() - 2])
                    ),
                "{text}"
            );
            assert!(!right(&text.replacen('2', "3", 1)), "{text}");
        }
        assert_eq!(checksums("$GPVTG,220.86,T,,M"), [("GPVTG".to_owned(), false)]);
        assert_eq!(checksums("$GPVTG,1*+5"), [("GPVTG".to_owned(), false)]);
    }

    #[test]
    fn sentences_that_share_a_line_are_separated() {
        let line = "12:00 $HEHDT,68.755,T*16$HEROT,275.0212:01 !AIVDM,1,1,,A,0,0*16[5] $HEHDT,69.672,T*13 ";
        let found: Vec<(&str, String, bool)> = raw_sentences(line)
            .map(|raw| (raw.prefix, raw.sentence().0.address.to_owned(), raw.is_followed))
            .collect();
        let expected = [("12:00 ", "HEHDT", true), ("", "HEROT", true), ("[5] ", "HEHDT", false)];
        assert_eq!(found, expected.map(|(prefix, address, followed)| (prefix, address.to_owned(), followed)));
        assert!(
            raw_sentences("nothing! $").count() == 1
                && raw_sentences("").count() == 0
                && raw_sentences("a*b").count() == 0
        );
    }
}
