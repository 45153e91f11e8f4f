//! Medians of more values than fit in memory, if these can be iterated repeatedly.

use super::{median, quantile};

/// Most values to select from in memory.
const IN_MEMORY: usize = 1 << 18;

/// Bits of a value's rank that one pass determines.
const BITS: u32 = 16;

/// [`median`], bit for bit, of the values that `values` yields each time it is called. If there are many,
/// each pass counts how many have the same leading bits, until those that contain the median fit in the
/// memory.
pub fn median_again<I: Iterator<Item = f64>>(values: impl Fn() -> I) -> Option<f64> {
    let few: Vec<f64> = values().take(IN_MEMORY + 1).collect();
    if few.len() <= IN_MEMORY {
        return median(few);
    }
    drop(few);
    let keys = || values().map(key);
    let last = values().count() - 1;
    let low = ranked(&keys, last / 2);
    if last.is_multiple_of(2) {
        return quantile(&[value(low)], 0.5);
    }
    let (mut up_to, mut above) = (0, u64::MAX);
    keys().for_each(|key| if key <= low { up_to += 1 } else { above = above.min(key) });
    let high = if up_to > last / 2 + 1 { low } else { above };
    quantile(&[value(low), value(high)], 0.5)
}

/// The key of rank `rank`, from 0.
fn ranked<I: Iterator<Item = u64>>(keys: &impl Fn() -> I, mut rank: usize) -> u64 {
    let (mut known, mut prefix) = (0, 0);
    loop {
        let before = known;
        let inside = |key: &u64| before == 0 || key >> (u64::BITS - before) == prefix;
        known += BITS;
        let leading = |key: u64| key >> (u64::BITS - known);
        let mut counts = vec![0; 1 << BITS];
        keys().filter(inside).for_each(|key| counts[(leading(key) & 0xffff) as usize] += 1);
        let mut bin = 0;
        while rank >= counts[bin] {
            rank -= counts[bin];
            bin += 1;
        }
        prefix = prefix << BITS | bin as u64;
        if known == u64::BITS {
            return prefix;
        }
        if counts[bin] <= IN_MEMORY {
            let mut few: Vec<u64> = keys().filter(|key| leading(*key) == prefix).collect();
            return *few.select_nth_unstable(rank).1;
        }
    }
}

/// An integer that orders like the values.
fn key(value: f64) -> u64 {
    let bits = value.to_bits();
    if bits >> 63 == 1 { !bits } else { bits | 1 << 63 }
}

/// The value of a key.
fn value(key: u64) -> f64 {
    f64::from_bits(if key >> 63 == 1 { key ^ 1 << 63 } else { !key })
}
