//! A part of a computation that is distributed over several processes.

use std::fmt;
use std::ops::Range;
use std::str::FromStr;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Part `index` of `count`, written `K/N` with 1 ≤ K ≤ N.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize, JsonSchema)]
#[serde(try_from = "String", into = "String")]
#[schemars(with = "String", extend("pattern" = "^[1-9][0-9]*/[1-9][0-9]*$"))]
pub struct Shard {
    /// Number of this part, from 1.
    pub index: u32,
    /// Number of parts.
    pub count: u32,
}

impl Shard {
    /// The items, out of `items`, that belong to this part.
    ///
    /// The ranges of the parts 1 to N follow each other, cover `0..items`, and their lengths
    /// differ by at most one. A part outside `1..=count` has no items.
    pub fn range(&self, items: usize) -> Range<usize> {
        if self.index == 0 || self.index > self.count {
            return 0..0;
        }
        let bound = |parts: u32| {
            let product = items as u128 * u128::from(parts) / u128::from(self.count);
            product as usize // at most `items`
        };
        bound(self.index - 1)..bound(self.index)
    }
}

impl fmt::Display for Shard {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}", self.index, self.count)
    }
}

/// Why a text is not a [`Shard`].
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("`{0}` is not a shard: expected K/N with whole numbers 1 <= K <= N, like 2/4")]
pub struct NotAShard(String);

impl FromStr for Shard {
    type Err = NotAShard;

    fn from_str(text: &str) -> Result<Self, NotAShard> {
        let wrong = || NotAShard(text.to_owned());
        let (index, count) = text.split_once('/').ok_or_else(wrong)?;
        let number = |part: &str| part.parse::<u32>().ok().filter(|n| n.to_string() == part);
        let index = number(index).ok_or_else(wrong)?;
        let count = number(count).ok_or_else(wrong)?;
        if index == 0 || index > count { Err(wrong()) } else { Ok(Self { index, count }) }
    }
}

impl TryFrom<String> for Shard {
    type Error = NotAShard;

    fn try_from(text: String) -> Result<Self, NotAShard> {
        text.parse()
    }
}

impl From<Shard> for String {
    fn from(shard: Shard) -> Self {
        shard.to_string()
    }
}
