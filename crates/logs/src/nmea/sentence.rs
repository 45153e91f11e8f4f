//! Sentences: their start in a line, address, fields, checksum.

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::{Deserialize, Deserializer, Error, Visitor};

/// A sentence: `$`, an address, fields.
#[derive(Clone, Copy)]
pub(crate) struct Sentence<'a> {
    /// Talker and kind: `GPRMC`.
    pub(crate) address: &'a str,
    /// Between `$` and `*`.
    body: &'a str,
}

impl<'a> Sentence<'a> {
    /// Field `i`, from 0; empty where there is none.
    pub(crate) fn field(&self, i: usize) -> &'a str {
        self.body.split(',').nth(i + 1).map_or("", str::trim)
    }

    /// Number of fields.
    pub(crate) fn fields(&self) -> usize {
        self.body.bytes().filter(|byte| *byte == b',').count()
    }

    /// Whether its kind is `kind`; proprietary sentences, which begin with P, are of no kind.
    pub(crate) fn is_a(&self, kind: &str) -> bool {
        self.address.len() == 5
            && self.address.is_ascii()
            && self.address.ends_with(kind)
            && !self.address.starts_with('P')
    }
}

/// The text from one `$` to the next.
pub(crate) struct RawSentence<'a> {
    /// The text before it on the line that belongs to no other sentence.
    pub(super) prefix: &'a str,
    /// From `$` to the end of the checksum.
    text: &'a str,
    /// Whether the next sentence begins on the same line.
    pub(super) is_followed: bool,
}

/// The state of a checksum.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Checksum {
    Right,
    Wrong,
    None,
}

/// The sentences of a line: each begins with a `$`. AIS sentences, which begin with a `!`, are left out but
/// end the previous one.
pub(crate) fn raw_sentences(line: &str) -> impl Iterator<Item = RawSentence<'_>> {
    let mut rest = start(line);
    let mut before = &line[..line.len() - rest.len()];
    std::iter::from_fn(move || {
        while !rest.is_empty() {
            let next = start(&rest[1..]);
            let whole = &rest[..rest.len() - next.len()];
            let (text, after) = whole.split_at(end(whole));
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
        b'!' => bytes.get(i + 1..i + 4).is_some_and(|letters| letters.iter().all(u8::is_ascii_uppercase)),
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
    pub(crate) fn sentence(&self) -> (Sentence<'a>, Checksum) {
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

/// Qualities whose values count: fixes of GGA by digits, modes by letters.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Accepted(Vec<Quality>);

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Quality(char);

impl<'de> Deserialize<'de> for Accepted {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        Vec::deserialize(deserializer).map(Self)
    }
}

impl<'de> Deserialize<'de> for Quality {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct One;
        impl Visitor<'_> for One {
            type Value = Quality;

            fn expecting(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
                f.write_str("a fix such as 4, or a mode such as \"D\"")
            }

            fn visit_i64<E: Error>(self, fix: i64) -> Result<Quality, E> {
                let digit = u32::try_from(fix).ok().and_then(|fix| char::from_digit(fix, 10));
                digit.map(Quality).ok_or_else(|| E::invalid_value(serde::de::Unexpected::Signed(fix), &self))
            }

            fn visit_str<E: Error>(self, mode: &str) -> Result<Quality, E> {
                match mode.as_bytes() {
                    [letter] if letter.is_ascii_alphanumeric() => {
                        Ok(Quality(char::from(letter.to_ascii_uppercase())))
                    }
                    _ => Err(E::invalid_value(serde::de::Unexpected::Str(mode), &self)),
                }
            }
        }
        deserializer.deserialize_any(One)
    }
}

impl JsonSchema for Accepted {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        "Accepted".into()
    }

    fn inline_schema() -> bool {
        true
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({ "type": "array", "items": { "type": ["integer", "string"] } })
    }
}

/// The condition under which values of a sentence count; numbers are those of fields.
#[derive(Clone, Copy)]
pub(super) enum Valid {
    Always,
    /// Where a field is `A`.
    A(usize),
    /// Where a field is a letter, or empty.
    Letter(usize, &'static str),
    /// By the fix quality of GGA.
    Fix(usize),
    /// By one of several modes.
    AnyMode(usize),
    /// By a mode, and a status that is `A`; old sentences have no mode.
    Mode {
        status: Option<usize>,
        mode: usize,
    },
    /// By a mode that must be present.
    OwnMode(usize),
}

/// Fix qualities that are not measured: none, dead reckoning, manual, simulated.
const NO_FIX: &str = "0678";

/// Modes that are not measured: estimated, manual, simulated, not valid.
const NO_MODE: &str = "EMSNV";

impl Accepted {
    /// Whether the values of `sentence` count.
    pub(super) fn counts(&self, valid: Valid, sentence: &Sentence) -> bool {
        match valid {
            Valid::Always => true,
            Valid::A(place) => sentence.field(place) == "A",
            Valid::Letter(place, letter) => ["", letter].contains(&sentence.field(place)),
            Valid::Fix(place) => self.all(sentence.field(place), |c| c.is_ascii_digit(), NO_FIX),
            Valid::AnyMode(place) => sentence
                .field(place)
                .split("")
                .any(|mode| self.all(mode, |c| c.is_ascii_alphabetic(), NO_MODE)),
            Valid::OwnMode(place) => self.is_mode(sentence.field(place)),
            Valid::Mode { status, mode } => {
                let mode = sentence.field(mode);
                let is_a = status.is_none_or(|place| sentence.field(place) == "A");
                let named = self.0.iter().any(|quality| mode.chars().eq([quality.0]));
                let old = mode.is_empty() && !self.names(|c| c.is_ascii_alphabetic());
                named || is_a && (old || self.is_mode(mode))
            }
        }
    }

    fn is_mode(&self, mode: &str) -> bool {
        self.all(mode, |c| c.is_ascii_alphabetic(), NO_MODE)
    }

    fn names(&self, kind: fn(&char) -> bool) -> bool {
        self.0.iter().any(|quality| kind(&quality.0))
    }

    /// Whether there is a quality and every character of it is accepted: those of the `kind` that are named,
    /// or by default all but `none`.
    fn all(&self, quality: &str, kind: fn(&char) -> bool, none: &str) -> bool {
        let named = self.names(kind);
        let accepts = |c: char| if named { self.0.contains(&Quality(c)) } else { !none.contains(c) };
        !quality.is_empty() && quality.chars().all(accepts)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn checksums(line: &str) -> Vec<(String, bool)> {
        let read = |raw: RawSentence| {
            let (sentence, checksum) = raw.sentence();
            (sentence.address.to_owned(), checksum == Checksum::Right)
        };
        raw_sentences(line).map(read).collect()
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
        let read: Vec<(&str, String, bool)> = raw_sentences(line)
            .map(|raw| (raw.prefix, raw.sentence().0.address.to_owned(), raw.is_followed))
            .collect();
        let expected = [("12:00 ", "HEHDT", true), ("", "HEROT", true), ("[5] ", "HEHDT", false)];
        assert_eq!(read, expected.map(|(prefix, address, followed)| (prefix, address.to_owned(), followed)));
        assert!(
            raw_sentences("nothing! $").count() == 1
                && raw_sentences("").count() == 0
                && raw_sentences("a*b").count() == 0
        );
    }

    fn counts(accepted: &str, valid: Valid, line: &str) -> bool {
        let accepted = Accepted(accepted.chars().map(Quality).collect());
        raw_sentences(line).all(|raw| accepted.counts(valid, &raw.sentence().0))
    }

    #[test]
    fn no_fix_and_guesses_count_where_they_are_accepted() {
        let fix = |accepted: &str, fix: &str| counts(accepted, Valid::Fix(0), &format!("$GPGGA,{fix}"));
        assert!(["1", "2", "3", "4", "5", "9"].into_iter().all(|digit| fix("", digit) && fix("E", digit)));
        assert!(["", "0", "6", "7", "8"].into_iter().all(|digit| !fix("", digit)));
        assert!(fix("46", "6") && !fix("46", "5") && !fix("4", "44x"));
        let mode = Valid::Mode { status: Some(0), mode: 1 };
        let modes = |accepted: &str, text: &str| counts(accepted, mode, &format!("$GPRMC,{text}"));
        assert!(modes("", "A,A") && modes("", "A,") && modes("4", "A") && modes("", "A,D"));
        assert!(["V,A", "V,", "A,E", "A,M", "A,S", "A,N"].into_iter().all(|text| !modes("", text)));
        assert!(modes("E", "V,E") && !modes("E", "A,A") && !modes("D", "A,"));
        let any = |text: &str| counts("", Valid::AnyMode(0), &format!("$GNGNS,{text}"));
        assert!(any("AN") && any("NRN") && !any("NN") && !any("EN") && !any(""));
        let heading = |text: &str| counts("", Valid::OwnMode(0), &format!("$HETHS,{text}"));
        assert!(heading("A") && !heading("") && !heading("E") && !heading("V"));
    }
}
