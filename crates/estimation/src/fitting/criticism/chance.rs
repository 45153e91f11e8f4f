//! How often chance makes any candidate look as likely.

use rand::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use rayon::prelude::*;

use super::scores::Score;

/// Number of draws.
const DRAWS: usize = 2000;

/// For each score the probability that, if no candidate were missing, any of them had as large a score. Signs of the
/// independent units are drawn, the same ones for all scores, so that candidates that resemble each other count as one.
pub(crate) fn probabilities(scores: &[&Score]) -> Vec<f64> {
    let rows = scores.first().map_or(0, |own| own.units.len());
    let deviations: Vec<f64> =
        scores.iter().map(|own| own.variance().sqrt().max(f64::MIN_POSITIVE)).collect();
    let standardised: Vec<Vec<f64>> = (0..rows)
        .map(|row| {
            scores.iter().zip(&deviations).map(|(own, deviation)| own.units[row] / deviation).collect()
        })
        .collect();
    let draws: Vec<f64> =
        (0..DRAWS as u64).into_par_iter().map(|seed| largest(&standardised, seed)).collect();
    let probability = |own: &&Score| {
        let as_large = draws.iter().filter(|draw| **draw >= own.standardised().abs()).count();
        (as_large + 1) as f64 / (DRAWS + 1) as f64
    };
    scores.iter().map(probability).collect()
}

/// The largest score of draw number `seed`.
fn largest(rows: &[Vec<f64>], seed: u64) -> f64 {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(seed);
    let mut sums = vec![0.0; rows.first().map_or(0, Vec::len)];
    let mut bits = 0;
    for (k, row) in rows.iter().enumerate() {
        if k % 64 == 0 {
            bits = random.next_u64();
        }
        let sign = if bits >> (k % 64) & 1 == 0 { 1.0 } else { -1.0 };
        sums.iter_mut().zip(row).for_each(|(sum, own)| *sum += sign * own);
    }
    sums.iter().fold(0.0, |most, own| own.abs().max(most))
}
