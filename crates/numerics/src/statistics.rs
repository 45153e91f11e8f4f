//! Quantiles and spread over runs; tail probabilities.

use statrs::distribution::{ChiSquared, ContinuousCDF};
use statrs::function::erf::erfc;

use crate::Number;

/// Mean; `None` if empty.
pub fn mean(values: &[f64]) -> Option<f64> {
    (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
}

/// Standard deviation, `None` below two values.
pub fn spread(values: &[f64]) -> Option<f64> {
    let mean = mean(values)?;
    let squares: f64 = values.iter().map(|x| (x - mean) * (x - mean)).sum();
    (values.len() > 1).then(|| (squares / (values.len() - 1) as f64).sqrt())
}

/// The quantile `q` of ascending `sorted`, interpolated; `None` if empty or among infinite values.
pub fn quantile(sorted: &[f64], q: f64) -> Option<f64> {
    let last = sorted.len().checked_sub(1)?;
    let place = q * last as f64;
    let (low, high) = (place.floor() as usize, place.ceil() as usize);
    let value = if low == high {
        sorted[low]
    } else {
        sorted[low] + (place - low as f64) * (sorted[high] - sorted[low])
    };
    value.is_finite().then_some(value)
}

/// The quantile 0.5 of `values` in any order, by selection, which is faster than sorting for many values.
pub fn median(mut values: Vec<f64>) -> Option<f64> {
    let last = values.len().checked_sub(1)?;
    let (_, low, above) = values.select_nth_unstable_by(last / 2, f64::total_cmp);
    let low = *low;
    match above.iter().copied().min_by(f64::total_cmp).filter(|_| last % 2 == 1) {
        Some(high) => quantile(&[low, high], 0.5),
        None => quantile(&[low], 0.5),
    }
}

/// Ascending, absent values last as infinity.
pub fn sorted(values: impl Iterator<Item = Option<f64>>) -> Vec<f64> {
    let mut all: Vec<f64> = values.map(|v| v.unwrap_or(f64::INFINITY)).collect();
    all.sort_by(f64::total_cmp);
    all
}

/// Most values to select from in memory.
const IN_MEMORY: usize = 1 << 18;

/// Bits of a value's rank that one pass determines.
const BITS: u32 = 16;

/// [`median`], bit for bit, of the values that `values` yields each time it is called. If there are many, each pass counts how
/// many have the same leading bits, until those that contain the median fit in the memory.
pub fn streamed_median<I: Iterator<Item = f64>>(values: impl Fn() -> I) -> Option<f64> {
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

/// Fewest draws of which two enclose the median of their distribution at 95 %.
pub const LEAST_FOR_MEDIAN: u64 = 6;

/// The 95 % interval of the median of `pairs` pairs in words, such as `0.9 to 1.1`. An end is missing where
/// the pairs do not bound it.
///
/// # Errors
/// Why there is none: too few pairs, or too many of which one has no value.
pub fn median_interval_in_words(
    ends: [Option<f64>; 2],
    pairs: u64,
    number: impl Fn(f64) -> String,
) -> Result<String, String> {
    if pairs < LEAST_FOR_MEDIAN {
        return Err(format!("too few pairs for a 95 % interval: {pairs}, at least {LEAST_FOR_MEDIAN}"));
    }
    match ends.map(|end| end.filter(|end| end.is_finite()).map(&number)) {
        [Some(low), Some(high)] => Ok(format!("{low} to {high}")),
        [Some(low), None] => Ok(format!("from {low} up")),
        [None, Some(high)] => Ok(format!("up to {high}")),
        [None, None] => Err("no 95 % interval: too many pairs of which one has no value".to_owned()),
    }
}

/// Trajectories that are averaged sample by sample.
///
/// The mean moves towards each by its share of what it is off, so that the mean of equals is what they are, to the bit.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MeanTrajectory<N> {
    count: u32,
    mean: Vec<N>,
    /// Sums of squared distances from the mean.
    squares: Vec<N>,
}

impl<N: Number> MeanTrajectory<N> {
    /// Adds one, as long as the others.
    pub fn add(&mut self, states: &[N]) {
        if self.count == 0 {
            (self.mean, self.squares) = (states.to_vec(), vec![N::ZERO; states.len()]);
        }
        self.count += 1;
        let share = N::from(f64::from(self.count).recip());
        for ((mean, squares), state) in self.mean.iter_mut().zip(&mut self.squares).zip(states) {
            let off = *state - *mean;
            *mean += off * share;
            *squares += off * (*state - *mean);
        }
    }

    /// The mean.
    pub fn mean(&self) -> &[N] {
        &self.mean
    }
}

impl MeanTrajectory<f64> {
    /// Standard deviations of the trajectories about their mean, with one less than their number; 0 of a single one.
    pub fn spread(&self) -> Vec<f64> {
        let freedom = f64::from(self.count.max(2) - 1);
        self.squares.iter().map(|sum| (sum / freedom).sqrt()).collect()
    }
}

/// The 97.5 % quantile of the standard normal distribution.
pub const Z: f64 = 1.959_963_984_540_054;
/// Probability with which each end of an interval may miss.
const TAIL: f64 = 0.025;

/// Wilson's score interval of a share: 95 % `[low, high]` after `count` successes in `total` trials; `None` without trials.
///
/// It is valid for shares near 0 and 1 too, where an estimate ± 1.96 standard errors is not.
pub fn wilson(count: u64, total: u64) -> Option<[f64; 2]> {
    if total == 0 {
        return None;
    }
    let [low, high] = score(count as f64 / total as f64, total as f64, Z);
    // The ends are exact where all trials failed or succeeded; rounding must not move them off 0 and 1.
    Some([if count == 0 { 0.0 } else { low }, if count == total { 1.0 } else { high }])
}

/// Wilson's score interval of a `share` of so many trials, `z` standard errors to either side.
fn score(share: f64, trials: f64, z: f64) -> [f64; 2] {
    let weight = z * z / trials;
    let centre = share + 0.5 * weight;
    let half = (weight * (share * (1.0 - share) + 0.25 * weight)).sqrt();
    [(centre - half) / (1.0 + weight), (centre + half) / (1.0 + weight)]
}

/// 95 % interval `[low, high]` of the mean of `shares`, each of a cluster of as many trials, which need not be independent
/// within it: Wilson's for as many independent trials as would make the shares vary so, by Student's t. `None` below two.
pub fn clustered_share(shares: &[f64]) -> Option<[f64; 2]> {
    let (clusters, share) = (shares.len() as f64, mean(shares)?);
    let variance = spread(shares)?.powi(2) / clusters;
    let trials = if variance > 0.0 { share * (1.0 - share) / variance } else { clusters };
    Some(score(share, trials, student_half_width(clusters - 1.0)).map(|end| end.clamp(0.0, 1.0)))
}

/// 95 % interval `[low, high]` of the mean of the distribution of `values` by Student's t, if they are normal or many;
/// `None` below two.
pub fn mean_interval(values: &[f64]) -> Option<[f64; 2]> {
    let n = values.len() as f64;
    let half = student_half_width(n - 1.0) * spread(values)? / n.sqrt();
    mean(values).map(|mean| [mean - half, mean + half])
}

/// 95 % interval `[low, high]` of the quantile `q` of the distribution of ascending `sorted` values: two of
/// the values, each of which misses the quantile with a probability of at most 2.5 %, for any distribution.
/// An end is `None` where there are too few values for it, or where it falls among infinite ones.
pub fn quantile_interval(sorted: &[f64], q: f64) -> [Option<f64>; 2] {
    ranks(sorted.len(), q)
        .map(|rank| sorted.get(rank?.checked_sub(1)?).copied().filter(|value| value.is_finite()))
}

/// Ranks, from 1, of the values that enclose the quantile `q` of `n` draws.
///
/// The number of draws below the quantile is binomial: the value of rank l lies above the quantile where fewer than l draws
/// lie below it, and the value of rank u lies below it where at least u do.
fn ranks(n: usize, q: f64) -> [Option<usize>; 2] {
    let masses = binomial(n, q);
    let tail = |masses: &mut dyn Iterator<Item = f64>| {
        let mut sum = 0.0;
        masses.take_while(|mass| within(&mut sum, *mass)).count()
    };
    let below = tail(&mut masses.iter().copied());
    let above = tail(&mut masses.iter().rev().copied());
    [(below > 0).then_some(below), (above > 0).then(|| n + 1 - above)]
}

/// Beyond so many draws the normal approximation of the binomial distribution is used: its ranks differ by one at most.
const MANY: u64 = 10_000;

/// Ranks, from 1, of the values among `n` draws that enclose the quantile `q` at 95 %, as [`quantile_interval`] does, for any
/// number of draws. An end is `None` where there are too few.
pub fn quantile_ranks(n: u64, q: f64) -> [Option<u64>; 2] {
    if n <= MANY {
        return ranks(n as usize, q).map(|rank| rank.map(|rank| rank as u64));
    }
    let (below, half) = (n as f64 * q, Z * (n as f64 * q * (1.0 - q)).sqrt());
    [Some((below - half).floor() as u64), Some((below + half).ceil() as u64 + 1)]
        .map(|rank| rank.filter(|rank| (1..=n).contains(rank)))
}

/// Adds `mass` to the `sum` of a tail; returns whether it is still at most [`TAIL`].
fn within(sum: &mut f64, mass: f64) -> bool {
    *sum += mass;
    *sum <= TAIL
}

/// Probabilities of 0 … n successes in `n` trials that each succeed with probability `q`.
fn binomial(n: usize, q: f64) -> Vec<f64> {
    let odds = libm::log(q / (1.0 - q));
    let mut logarithm = n as f64 * libm::log(1.0 - q);
    let mut masses = vec![libm::exp(logarithm)];
    for k in 1..=n {
        logarithm += libm::log((n + 1 - k) as f64 / k as f64) + odds;
        masses.push(libm::exp(logarithm));
    }
    masses
}

/// Median of the differences `other − one` over pairs and its 95 % interval: `[low, median, high]`, where an
/// end is infinite that falls among infinite differences or that there are too few pairs for. A missing value
/// counts as infinite; pairs that miss both do not differ. `None` if empty.
pub fn paired_median(pairs: impl Iterator<Item = [Option<f64>; 2]>) -> Option<[f64; 3]> {
    let difference = |[one, other]: [Option<f64>; 2]| match (one, other) {
        (Some(one), Some(other)) => other - one,
        (Some(_), None) => f64::INFINITY,
        (None, Some(_)) => f64::NEG_INFINITY,
        (None, None) => 0.0,
    };
    let differences = sorted(pairs.map(|pair| Some(difference(pair))));
    let middle = median_of_sorted(&differences)?;
    let [low, high] =
        ranks(differences.len(), 0.5).map(|rank| rank.and_then(|r| differences.get(r - 1)).copied());
    Some([low.unwrap_or(f64::NEG_INFINITY), middle, high.unwrap_or(f64::INFINITY)])
}

/// The median of ascending values, infinite where it falls among infinite ones.
fn median_of_sorted(sorted: &[f64]) -> Option<f64> {
    let upper = *sorted.get(sorted.len() / 2)?;
    Some(quantile(sorted, 0.5).unwrap_or(upper))
}

// Tail probabilities.

/// P(χ² ≥ x) for `freedom` degrees of freedom; 1 without any.
pub fn chi_square_tail(x: f64, freedom: f64) -> f64 {
    ChiSquared::new(freedom).map_or(1.0, |distribution| distribution.sf(x))
}

/// log P(χ² ≥ x) for `freedom` degrees of freedom, at least one; by the tail's expansion if the probability underflows.
pub fn log_chi_square_tail(x: f64, freedom: usize) -> f64 {
    let (p, half) = (chi_square_tail(x.max(0.0), freedom as f64), 0.5 * freedom as f64);
    match p > 1e-290 {
        true => libm::log(p),
        false => (half - 1.0) * libm::log(0.5 * x) - 0.5 * x - libm::lgamma(half),
    }
}

/// P(|Z| ≥ |z|) for a standard normal Z, to a relative 1e-10.
pub fn normal_tails(z: f64) -> f64 {
    erfc(z.abs() / std::f64::consts::SQRT_2)
}

/// Half the width of a 95 % interval by Student's t with `freedom` degrees of freedom, in standard errors: by
/// the expansion of Fisher and Cornish (*Technometrics* 2, 1960), to a relative 2e-4, from nine degrees on. Below, that of
/// the whole degrees; infinite without one.
pub fn student_half_width(freedom: f64) -> f64 {
    const Z: f64 = 1.959_963_985;
    const FEW: [f64; 9] = [
        f64::INFINITY,
        12.706_204_736,
        4.302_652_730,
        3.182_446_305,
        2.776_445_105,
        2.570_581_836,
        2.446_911_851,
        2.364_624_252,
        2.306_004_135,
    ];
    if let Some(few) = FEW.get(freedom as usize) {
        return *few;
    }
    let square = Z * Z;
    let first = (square + 1.0) / 4.0;
    let second = ((5.0 * square + 16.0) * square + 3.0) / 96.0;
    let third = (((3.0 * square + 19.0) * square + 17.0) * square - 15.0) / 384.0;
    Z * (1.0 + (first + (second + third / freedom) / freedom) / freedom)
}
