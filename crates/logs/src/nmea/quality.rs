//! Which values count: those with a fix, in a mode, with a status that the sentence states.

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::{Deserialize, Deserializer, Error, Visitor};

use super::sentence::Sentence;

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
                let named = self.0.iter().any(|own| mode.chars().eq([own.0]));
                let old = mode.is_empty() && !self.names(|c| c.is_ascii_alphabetic());
                named || is_a && (old || self.is_mode(mode))
            }
        }
    }

    fn is_mode(&self, mode: &str) -> bool {
        self.all(mode, |c| c.is_ascii_alphabetic(), NO_MODE)
    }

    fn names(&self, kind: fn(&char) -> bool) -> bool {
        self.0.iter().any(|own| kind(&own.0))
    }

    /// Whether there is a quality and every character of it is accepted: those of the `kind` that are named,
    /// or by default all but `none`.
    fn all(&self, quality: &str, kind: fn(&char) -> bool, none: &str) -> bool {
        let named = self.names(kind);
        let own = |c: char| if named { self.0.contains(&Quality(c)) } else { !none.contains(c) };
        !quality.is_empty() && quality.chars().all(own)
    }
}

#[cfg(test)]
mod tests {
    use super::super::sentence::raw_sentences;
    use super::*;

    fn counts(accepted: &str, valid: Valid, line: &str) -> bool {
        let accepted = Accepted(accepted.chars().map(Quality).collect());
        raw_sentences(line).all(|raw| accepted.counts(valid, &raw.sentence().0))
    }

    #[test]
    fn no_fix_and_guesses_count_where_they_are_accepted() {
        let fix = |accepted: &str, fix: &str| counts(accepted, Valid::Fix(0), &format!("$GPGGA,{fix}"));
        assert!(["1", "2", "3", "4", "5", "9"].into_iter().all(|own| fix("", own) && fix("E", own)));
        assert!(["", "0", "6", "7", "8"].into_iter().all(|own| !fix("", own)));
        assert!(fix("46", "6") && !fix("46", "5") && !fix("4", "44x"));
        let mode = Valid::Mode { status: Some(0), mode: 1 };
        let modes = |accepted: &str, text: &str| counts(accepted, mode, &format!("$GPRMC,{text}"));
        assert!(modes("", "A,A") && modes("", "A,") && modes("4", "A") && modes("", "A,D"));
        assert!(["V,A", "V,", "A,E", "A,M", "A,S", "A,N"].into_iter().all(|text| !modes("", text)));
        assert!(modes("E", "V,E") && !modes("E", "A,A") && !modes("D", "A,"));
        let any = |text: &str| counts("", Valid::AnyMode(0), &format!("$GNGNS,{text}"));
        assert!(any("AN") && any("NRN") && !any("NN") && !any("EN") && !any(""));
        let own = |text: &str| counts("", Valid::OwnMode(0), &format!("$HETHS,{text}"));
        assert!(own("A") && !own("") && !own("E") && !own("V"));
    }
}
