//! 95 % intervals of shares, quantiles and paired differences.

use super::{mean, quantile, sorted, spread};
use crate::distributions::student_half_width;

/// The 97.5 % quantile of the standard normal distribution.
pub const Z: f64 = 1.959_963_984_540_054;
/// Probability with which each end of an interval may miss.
const TAIL: f64 = 0.025;

/// Wilson's score interval of a share: 95 % `[low, high]` after `count` successes in `total` trials; `None`
/// without trials.
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

/// Beyond so many draws the normal approximation of the binomial distribution is used: its ranks differ by
/// one at most.
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
    let median = median(&differences)?;
    let [low, high] =
        ranks(differences.len(), 0.5).map(|rank| rank.and_then(|r| differences.get(r - 1)).copied());
    Some([low.unwrap_or(f64::NEG_INFINITY), median, high.unwrap_or(f64::INFINITY)])
}

/// The median of ascending values, infinite where it falls among infinite ones.
fn median(sorted: &[f64]) -> Option<f64> {
    let upper = *sorted.get(sorted.len() / 2)?;
    Some(quantile(sorted, 0.5).unwrap_or(upper))
}
