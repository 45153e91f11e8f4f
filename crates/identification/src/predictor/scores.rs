use vessel::Lane;

use crate::sensitivity::{Levels, Products, Recordings, Sensitivities, add_draws, add_start, backward};

/// Covariance of Σ sᵀWe where errors are correlated over less than about 2√N samples. free × free lanes.
pub(crate) fn correlated_scores(
    recordings: &Recordings,
    kept: &Sensitivities<Lane>,
    weights: [Lane; 3],
) -> Vec<Lane> {
    let (p, rows) = (kept.free(), recordings.longest() + 1);
    let mut scores = Vec::with_capacity(rows * p);
    for k in 0..rows {
        let e = &kept.errors[3 * k..3 * k + 3];
        let weighted = [weights[0] * e[0], weights[1] * e[1], weights[2] * e[2]];
        let score = |s: &[Lane; 3]| s[0] * weighted[0] + s[1] * weighted[1] + s[2] * weighted[2];
        scores.extend(kept.at(k).iter().map(score));
    }
    windowed(&scores, p)
}

/// What `levels` add to the covariance of Σ sᵀWe beside measurement noise, to first order around the run's simulation: every
/// draw enters the states and goes on with them; adjoints tell what a change of the states does to the scores. free × free
/// lanes.
pub(crate) fn disturbed_scores<const N: usize>(
    recordings: &Recordings,
    unknowns: &[Lane],
    kept: &Sensitivities<Lane>,
    weights: [Lane; 3],
    levels: &Levels,
) -> Vec<Lane> {
    let mut draws = Products::new(kept.free());
    let start = backward::<Lane, N>(
        recordings,
        unknowns,
        kept,
        weights,
        Some(levels),
        #[inline(always)]
        |local, adjoints: &[[Lane; N]]| add_draws(&mut draws, adjoints, local, levels),
    );
    add_start(&mut draws, &start, levels);
    draws.finish().square()
}

/// Covariance of the sum of the rows of `scores`, `p` entries each, correlated over less than about 2√N rows: the mean over all
/// windows of that many rows of (Σ over the window)(…)ᵀ per row, which is what Bartlett's weights 1 − |lag|/L give. p × p lanes.
pub(crate) fn windowed(scores: &[Lane], p: usize) -> Vec<Lane> {
    let window = (2.0 * ((scores.len() / p) as f64).sqrt()).round().max(1.0) as usize;
    let share = Lane::splat(1.0 / window as f64);
    vessel::vectorized!(products_of_windows(scores, p, window))
        .finish()
        .square()
        .into_iter()
        .map(|sum| share * sum)
        .collect()
}

/// Products of the sums over all windows of the rows of `scores`.
#[inline(always)]
fn products_of_windows(scores: &[Lane], p: usize, window: usize) -> Products<Lane> {
    let rows = scores.len() / p;
    let mut sum = vec![Lane::ZERO; p];
    let mut products = Products::new(p);
    for k in 0..rows + window {
        if k < rows {
            for (sum, g) in sum.iter_mut().zip(&scores[k * p..]) {
                *sum += *g;
            }
        }
        if k >= window {
            for (sum, g) in sum.iter_mut().zip(&scores[(k - window) * p..]) {
                *sum = *sum - *g;
            }
        }
        for (i, sum) in sum.iter().enumerate() {
            products.set(i, *sum);
        }
        products.advance();
    }
    products
}
