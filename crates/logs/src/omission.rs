//! What was left out of a log, value by value: counted by channel and reason.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

refusal::choices! {
    /// Why values of a channel were left out.
    pub enum Reason {
        /// Numbers that stand for no value.
        Missing = "missing",
        /// Beyond `valid`, or beyond what is possible where that is not said.
        Range = "range",
        /// Of a place that no ship gets to from the one before.
        Motion = "motion",
        /// The same value again and again while the ship moves.
        Frozen = "frozen",
        /// 0 N 0 E, where there is no fix.
        NullIsland = "0 N 0 E",
        /// Of a fix that is none, or of a quality that nobody asked for.
        Quality = "quality",
        /// Of a sentence that lacks what its value is made of, such as a heading without variation.
        Incomplete = "incomplete",
        /// Of a time that is not the clock's, or under a clock that was not set yet.
        Time = "time",
    }
}

/// Values of a channel that were left out for one reason.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Omission {
    /// The channel, or the column where no channel was made of it.
    pub channel: String,
    /// Why.
    pub reason: Reason,
    /// How many.
    pub count: u64,
}

/// What was left out, each channel and reason once, in order of first appearance.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Omissions(Vec<Omission>);

impl Omissions {
    /// Counts `count` more values of `channel`.
    pub fn add(&mut self, channel: &str, reason: Reason, count: u64) {
        if count == 0 {
            return;
        }
        match self.0.iter_mut().find(|known| known.channel == channel && known.reason == reason) {
            Some(known) => known.count += count,
            None => self.0.push(Omission { channel: channel.to_owned(), reason, count }),
        }
    }

    /// Adds the counts of `others`, whose columns belong to the channels that `named` returns.
    pub fn append<'a>(&mut self, others: &'a Self, named: impl Fn(&'a str) -> &'a str) {
        others.0.iter().for_each(|other| self.add(named(&other.channel), other.reason, other.count));
    }

    /// `14 values left out: 12 of psi (missing), 2 of y_u (range)`, naming only a few; `None` where there are
    /// none.
    pub fn in_words(&self) -> Option<String> {
        const NAMED: usize = 6;
        let all: u64 = self.0.iter().map(|one| one.count).sum();
        let one = |one: &Omission| format!("{} of `{}` ({})", one.count, one.channel, one.reason);
        let named: Vec<String> = self.0.iter().take(NAMED).map(one).collect();
        let more = self.0.len().saturating_sub(NAMED);
        let more = if more > 0 {
            format!(" and more of {more} other kinds, see ingest.json")
        } else {
            String::new()
        };
        (all > 0).then(|| format!("{all} values left out: {}{more}", named.join(", ")))
    }

    /// All of them.
    pub fn as_slice(&self) -> &[Omission] {
        &self.0
    }

    /// All of them.
    pub fn into_vec(self) -> Vec<Omission> {
        self.0
    }
}
