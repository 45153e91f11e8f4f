//! Which fields a log of sentences has values of, before anybody has said which are wanted.

use std::collections::BTreeMap;
use std::io::BufRead;

use super::clock::{DAY, reported_time};
use super::fields::{Value, fields_of};
use super::quality::Accepted;
use super::sentence::{Checksum, Sentence, raw_sentences};
use crate::LogError;
use crate::lines::Lines;

/// A field of sentences of one talker, with values.
#[derive(Clone, Debug, PartialEq)]
pub struct SpokenField {
    /// Its name as a column, without the talker: `HDT.heading`, `RPM-S1.speed`.
    pub column: String,
    /// The talker: `HE`.
    pub talker: String,
    /// Its unit.
    pub unit: &'static str,
    /// How many values there are.
    pub values: usize,
}

/// What a log of sentences has.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Spoken {
    /// Its fields with values, by talker.
    pub fields: Vec<SpokenField>,
    /// Kinds of sentences with a time, such as `RMC`, and how many there are of the talker with most.
    pub timed: BTreeMap<String, usize>,
    /// How long it is by the times of these \[s\].
    pub length_s: f64,
    /// Intact sentences, and how many of them have no checksum.
    pub sentences: [usize; 2],
}

/// Counts the values of all fields in the sentences of `bytes`. Sentences that are not intact do not count.
///
/// # Errors
/// Bytes that cannot be read.
pub fn sentence_census(bytes: impl BufRead) -> Result<Spoken, LogError> {
    let mut counted = Counted::default();
    let mut lines = Lines::new(bytes)?;
    while let Some((number, line)) = lines.bytes()? {
        for raw in raw_sentences(&String::from_utf8_lossy(line)) {
            let (sentence, checksum) = raw.sentence();
            if checksum != Checksum::Wrong {
                counted.take(&sentence, checksum == Checksum::None, number);
            }
        }
    }
    Ok(counted.finish())
}

/// Whether `text`, the beginning of a file, has a sentence with the right checksum.
pub fn has_sentences(text: &str) -> bool {
    let is_right = |line: &str| raw_sentences(line).any(|raw| raw.sentence().1 == Checksum::Right);
    text.lines().any(is_right)
}

/// A clock: its last time of day, how far it went \[s\], how often it spoke.
type Clock = (f64, f64, usize);

#[derive(Default)]
struct Counted {
    /// Values by column and talker.
    fields: BTreeMap<(String, String), (&'static str, usize)>,
    /// By address.
    clocks: BTreeMap<String, Clock>,
    sentences: [usize; 2],
}

impl Counted {
    fn take(&mut self, sentence: &Sentence, is_unchecked: bool, line: usize) {
        let Some((talker, _)) = sentence.address.split_at_checked(2) else { return };
        for (column, unit, value) in fields_of(sentence, line, &Accepted::default()) {
            if matches!(value, Value::Known(_) | Value::Undeviated(_)) {
                let known = self.fields.entry((column, talker.to_owned())).or_insert((unit, 0));
                known.1 += 1;
            }
        }
        self.sentences[0] += 1;
        self.sentences[1] += usize::from(is_unchecked);
        if let Ok(Some(time)) = reported_time(sentence)
            && time.is_fix
        {
            let (last, length, count) =
                self.clocks.entry(sentence.address.to_owned()).or_insert((time.of_day, 0.0, 0));
            let step = (time.of_day - *last).rem_euclid(DAY);
            // Late sentences set no time.
            if step < 0.5 * DAY {
                (*last, *length) = (time.of_day, *length + step);
            }
            *count += 1;
        }
    }

    fn finish(self) -> Spoken {
        let mut timed = BTreeMap::<String, usize>::new();
        for (address, (.., count)) in &self.clocks {
            let known = timed.entry(address[2..].to_owned()).or_default();
            *known = (*known).max(*count);
        }
        let field = |((column, talker), (unit, values))| SpokenField { column, talker, unit, values };
        Spoken {
            fields: self.fields.into_iter().map(field).collect(),
            timed,
            length_s: self.clocks.values().map(|(_, length, _)| *length).fold(0.0, f64::max),
            sentences: self.sentences,
        }
    }
}
