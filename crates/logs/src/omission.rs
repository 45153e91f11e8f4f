//! What was left out of a log, value by value: counted by channel and reason.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

refusal::choices! {
    /// Why values of a channel were left out.
    pub enum Reason {
        /// Numbers that stand for no value.
        Missing = "missing",
        /// Beyond what `valid` allows.
        Range = "range",
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

/// What was left out, each channel and reason once, in the order in which they came up first.
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

    /// Counts what `others` count, of channels as `named` calls their columns.
    pub fn append<'a>(&mut self, others: &'a Self, named: impl Fn(&'a str) -> &'a str) {
        others.0.iter().for_each(|other| self.add(named(&other.channel), other.reason, other.count));
    }

    /// All of them.
    pub fn into_vec(self) -> Vec<Omission> {
        self.0
    }
}
