use std::collections::BTreeMap;

use estimation::Quantiles;
use numerics::statistics::quantile_ranks;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Bits of a number's fraction that distinguish bins: 2⁸ bins per octave.
const BITS: u32 = 8;
/// Maximum relative error of a quantile: half the widest bin.
pub const QUANTILE_ERROR: f64 = 1.0 / (2 << BITS) as f64;

/// How many numbers from 0 fell into each of bins of equal relative width, 256 to an octave. A bin is a number's sign,
/// exponent and first bits, so that no rounding decides.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, try_from = "Listed", into = "Listed")]
#[schemars(with = "Listed")]
pub struct Histogram {
    bins: BTreeMap<u32, u64>,
    beyond: u64,
    ends: Option<[f64; 2]>,
}

/// The serialised form of a histogram.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct Listed {
    /// Where each bin that has any begins; it ends 1/256 of its octave further.
    from: Vec<f64>,
    /// How many are in each of these.
    count: Vec<u64>,
    /// How many are infinite: there was nothing to be measured.
    beyond: u64,
    /// The smallest and the largest finite number.
    ends: Option<[f64; 2]>,
}

fn bin(number: f64) -> u32 {
    (number.to_bits() >> (52 - BITS)) as u32
}

fn begin(bin: u32) -> f64 {
    f64::from_bits(u64::from(bin) << (52 - BITS))
}

impl Histogram {
    /// Counts a number from 0; an absent one counts as infinite.
    pub fn add(&mut self, number: Option<f64>) {
        match number.filter(|number| *number >= 0.0 && number.is_finite()) {
            None => self.beyond += 1,
            Some(number) => {
                // Adding 0 turns −0 into 0.
                *self.bins.entry(bin(number + 0.0)).or_default() += 1;
                let [low, high] = self.ends.unwrap_or([number; 2]);
                self.ends = Some([low.min(number), high.max(number)]);
            }
        }
    }

    /// Adds the counts of another histogram.
    pub fn merge(&mut self, other: &Self) {
        for (bin, count) in &other.bins {
            *self.bins.entry(*bin).or_default() += count;
        }
        self.beyond += other.beyond;
        let both = self.ends.zip(other.ends).map(|(a, b)| [a[0].min(b[0]), a[1].max(b[1])]);
        self.ends = both.or(self.ends).or(other.ends);
    }

    /// The count of all numbers, including infinite ones.
    pub fn count(&self) -> u64 {
        self.bins.values().sum::<u64>() + self.beyond
    }

    /// The count of infinite numbers.
    pub fn beyond(&self) -> u64 {
        self.beyond
    }

    /// The number of rank `rank`, from 0, to within [`QUANTILE_ERROR`]; `None` if it is infinite or there is none.
    pub fn ranked(&self, rank: u64) -> Option<f64> {
        let mut below = 0;
        let ranked = self.bins.iter().find(|(_, count)| {
            below += **count;
            rank < below
        });
        let [low, high] = self.ends?;
        let middle = |bin: u32| 0.5 * (begin(bin) + begin(bin + 1));
        ranked.map(|(bin, _)| middle(*bin).clamp(low, high))
    }

    /// The quantile `q`, to within [`QUANTILE_ERROR`]; `None` without numbers or among infinite ones.
    pub fn quantile(&self, q: f64) -> Option<f64> {
        let place = q * self.count().checked_sub(1)? as f64;
        let [low, high] = [place.floor(), place.ceil()].map(|rank| self.ranked(rank as u64));
        Some(low? + (place - place.floor()) * (high? - low?))
    }

    /// 95 % interval of the quantile `q` that the numbers were drawn from, by ranks; an end is `None` if there are
    /// too few numbers for it or if it is infinite.
    pub fn quantile_interval(&self, q: f64) -> [Option<f64>; 2] {
        quantile_ranks(self.count(), q).map(|rank| self.ranked(rank? - 1))
    }

    /// All quantiles that are reported for scores.
    pub fn quantiles(&self) -> Quantiles {
        Quantiles {
            min: self.ends.map(|[low, _]| low),
            q10: self.quantile(0.1),
            median: self.quantile(0.5),
            median_interval: Some(self.quantile_interval(0.5)),
            q90: self.quantile(0.9),
            q90_interval: Some(self.quantile_interval(0.9)),
            q99: self.quantile(0.99),
            max: self.ends.filter(|_| self.beyond == 0).map(|[_, high]| high),
        }
    }
}

impl From<Histogram> for Listed {
    fn from(whole: Histogram) -> Self {
        let (bins, count) = whole.bins.into_iter().unzip::<u32, u64, Vec<_>, Vec<_>>();
        Self { from: bins.into_iter().map(begin).collect(), count, beyond: whole.beyond, ends: whole.ends }
    }
}

impl TryFrom<Listed> for Histogram {
    type Error = String;

    fn try_from(listed: Listed) -> Result<Self, String> {
        let Listed { from, count, beyond, ends } = listed;
        let bins: BTreeMap<u32, u64> = from.iter().map(|from| bin(*from)).zip(count.clone()).collect();
        let ascending = bins.keys().copied().map(begin).eq(from.iter().copied());
        let counted = from.len() == count.len() && count.iter().all(|count| *count > 0);
        let enclosed = match ends {
            None => bins.is_empty(),
            Some(ends) => [bins.keys().next(), bins.keys().next_back()] == ends.map(bin).each_ref().map(Some),
        };
        (ascending && counted && enclosed).then_some(Self { bins, beyond, ends }).ok_or_else(|| {
            "`from` is to list ascending bins, `count` how many are in each, `ends` the least and largest"
                .to_owned()
        })
    }
}
