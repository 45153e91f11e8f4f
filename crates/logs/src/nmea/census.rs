//! Counts the sentences by address, and those that are not intact.

use std::collections::BTreeMap;
use std::io::BufRead;

use refusal::Invalid;

use super::fields::{FieldColumn, Value, fields_of};
use super::sentence::{Accepted, Checksum, Sentence, raw_sentences};
use super::timeline::{DAY, has_time, reported_time};
use crate::encoding::Lines;
use crate::{Checksums, FileSpec, LogError};

/// The sentences so far.
#[derive(Default)]
pub(super) struct Census {
    /// Whether sentences may be without a checksum.
    is_optional: bool,
    /// Endings of the addresses of wanted sentences.
    wanted: Vec<String>,
    by_address: BTreeMap<String, KnownAddress>,
    /// Wanted sentences, as far as can be seen; those that are not intact, and the line of the first.
    all: usize,
    broken: usize,
    without: usize,
    first_broken: Option<usize>,
    /// All sentences that are not intact.
    left: usize,
    /// Whether the last one has no checksum at all: it may have been cut short.
    last_is_cut: bool,
}

/// What is known of an address.
#[derive(Default)]
struct KnownAddress {
    /// Most fields of its sentences.
    fields: usize,
    /// Whether they have checksums.
    is_checked: bool,
}

impl Census {
    pub(super) fn new(spec: &FileSpec, wanted: &[FieldColumn]) -> Self {
        let clock = has_time(&spec.time.column).then(|| spec.time.column.clone());
        Self {
            is_optional: spec.checksums == Checksums::Optional || spec.max_wrong_checksums >= 1.0,
            wanted: wanted.iter().map(|column| column.address.clone()).chain(clock).collect(),
            ..Self::default()
        }
    }

    /// Counts a sentence on `line`, which another may follow; returns whether it is intact.
    pub(super) fn take(
        &mut self,
        sentence: &Sentence,
        checksum: Checksum,
        is_followed: bool,
        line: usize,
    ) -> bool {
        let is_whole = match checksum {
            Checksum::Right => true,
            Checksum::Wrong => false,
            Checksum::None => self.is_optional && !is_followed && self.is_like_others(sentence),
        };
        let is_wanted = self.is_wanted(sentence.address);
        self.last_is_cut = is_wanted && checksum == Checksum::None && !is_whole;
        self.all += usize::from(is_wanted);
        if is_whole {
            self.know(sentence, checksum);
            return true;
        }
        self.left += 1;
        self.without += usize::from(is_wanted && checksum == Checksum::None);
        if is_wanted {
            self.broken += 1;
            self.first_broken.get_or_insert(line);
        }
        false
    }

    /// Whether such sentences are wanted, or the address itself is not intact.
    pub(super) fn is_wanted(&self, address: &str) -> bool {
        let clean = address.bytes().all(|byte| byte.is_ascii_uppercase() || byte.is_ascii_digit());
        !clean || address.is_empty() || self.wanted.iter().any(|wanted| address.ends_with(wanted.as_str()))
    }

    /// Whether a sentence without checksum has as many fields as others of its address, and none of these has one.
    fn is_like_others(&self, sentence: &Sentence) -> bool {
        let known = self.by_address.get(sentence.address);
        known.is_none_or(|known| !known.is_checked && sentence.fields() >= known.fields)
    }

    fn know(&mut self, sentence: &Sentence, checksum: Checksum) {
        if !self.by_address.contains_key(sentence.address) {
            self.by_address.insert(sentence.address.to_owned(), KnownAddress::default());
        }
        if let Some(known) = self.by_address.get_mut(sentence.address) {
            known.fields = known.fields.max(sentence.fields());
            known.is_checked |= checksum == Checksum::Right;
        }
    }

    /// The addresses so far.
    pub(super) fn addresses(&self) -> impl Iterator<Item = &str> {
        self.by_address.keys().map(String::as_str)
    }

    /// How many sentences are left out for their checksums, and how many because the file ends within them.
    pub(super) fn finish(&self, spec: &FileSpec) -> Result<(usize, usize), Invalid> {
        let cut = usize::from(self.last_is_cut);
        let (wrong, share) = (self.broken.saturating_sub(cut), spec.max_wrong_checksums);
        if wrong as f64 > share * self.all as f64 {
            let first = self.first_broken.unwrap_or(0);
            let without = match self.without {
                0 => String::new(),
                without => format!(" ({without} without any)"),
            };
            let remedy = match 2 * self.without > wrong {
                true => "set `checksums = \"optional\"` in [[file]] to read sentences without them",
                false => "log again over a better line, or raise `max_wrong_checksums`",
            };
            return Err(Invalid::new(
                "checksums",
                format!("{wrong} wrong ones of {} sentences{without}, the first in line {first}", self.all),
                format!("a share of at most {share}"),
                remedy,
            ));
        }
        Ok((self.left - cut, cut))
    }
}

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
    let mut counted = SpokenCounts::default();
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
type ClockCount = (f64, f64, usize);

#[derive(Default)]
struct SpokenCounts {
    /// Values by column and talker.
    fields: BTreeMap<(String, String), (&'static str, usize)>,
    /// By address.
    clocks: BTreeMap<String, ClockCount>,
    sentences: [usize; 2],
}

impl SpokenCounts {
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
