//! Counts the sentences by address, and those that are not intact.

use std::collections::BTreeMap;

use refusal::Invalid;

use super::clock::has_time;
use super::fields::Column;
use super::sentence::{Checksum, Sentence};
use crate::{Checksums, FileSpec};

/// The sentences so far.
pub(super) struct Census {
    /// Whether sentences may be without a checksum.
    is_optional: bool,
    /// Endings of the addresses of wanted sentences.
    wanted: Vec<String>,
    by_address: BTreeMap<String, Known>,
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
struct Known {
    /// Most fields of its sentences.
    fields: usize,
    /// Whether they have checksums.
    is_checked: bool,
}

impl Census {
    pub(super) fn new(spec: &FileSpec, wanted: &[Column]) -> Self {
        let clock = has_time(&spec.time.column).then(|| spec.time.column.clone());
        Self {
            is_optional: spec.checksums == Checksums::Optional || spec.max_wrong_checksums >= 1.0,
            wanted: wanted.iter().map(|column| column.address.clone()).chain(clock).collect(),
            by_address: BTreeMap::new(),
            all: 0,
            broken: 0,
            without: 0,
            first_broken: None,
            left: 0,
            last_is_cut: false,
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
            self.by_address.insert(sentence.address.to_owned(), Known::default());
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
    ///
    /// # Errors
    /// More wrong checksums among wanted sentences than `spec` allows.
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
