use vessel::Lane;

use super::products::Products;
use super::recordings::Recordings;
use super::sweep::{Step, sweep};

/// A free simulation with its sensitivities, sample by sample.
pub(crate) struct Kept {
    /// Number of free unknowns.
    pub free: usize,
    /// Measured minus simulated, (N+1) × 3; zero where a sample does not count.
    pub errors: Vec<Lane>,
    /// Simulated states, (N+1) × 3.
    pub states: Vec<Lane>,
    /// ∂states/∂unknowns, (N+1) × free × 3; zero where a sample does not count.
    pub sensitivities: Vec<Lane>,
}

impl Kept {
    /// Of `recordings` simulated with `unknowns`.
    pub(crate) fn of(recordings: &Recordings, unknowns: &[Lane], free: &[usize], from_start: bool) -> Self {
        let rows = recordings.longest() + 1;
        let mut kept = Self {
            free: free.len(),
            errors: Vec::with_capacity(3 * rows),
            states: Vec::with_capacity(3 * rows),
            sensitivities: Vec::with_capacity(3 * rows * free.len()),
        };
        sweep(
            recordings,
            unknowns,
            free,
            None,
            &[],
            #[inline(always)]
            |step: Step<'_, 3>| {
                let counts = if step.k == 0 && !from_start { Lane::ZERO } else { recordings.lasting(step.k) };
                kept.errors.extend(step.error.map(|e| e * counts));
                kept.states.extend_from_slice(step.states);
                for s in step.sensitivities {
                    kept.sensitivities.extend(s.map(|s| s * counts));
                }
            },
        );
        kept
    }

    /// Sensitivities at sample `k`: free × 3.
    pub(crate) fn at(&self, k: usize) -> &[[Lane; 3]] {
        let width = 3 * self.free;
        self.sensitivities[k * width..(k + 1) * width].as_chunks().0
    }
}

/// Covariance of Σ sᵀWe where errors are correlated over less than about 2√N samples. free × free lanes.
pub(crate) fn correlated_scores(recordings: &Recordings, kept: &Kept, weights: [Lane; 3]) -> Vec<Lane> {
    let (p, rows) = (kept.free, recordings.longest() + 1);
    let mut scores = Vec::with_capacity(rows * p);
    for k in 0..rows {
        let e = &kept.errors[3 * k..3 * k + 3];
        let weighted = [weights[0] * e[0], weights[1] * e[1], weights[2] * e[2]];
        let score = |s: &[Lane; 3]| s[0] * weighted[0] + s[1] * weighted[1] + s[2] * weighted[2];
        scores.extend(kept.at(k).iter().map(score));
    }
    windowed(&scores, p)
}

/// Covariance of the sum of the rows of `scores`, `p` entries each, correlated over less than about 2√N rows: the mean over all
/// windows of that many rows of (Σ over the window)(…)ᵀ per row, which is what Bartlett's weights 1 − |lag|/L give. p × p lanes.
pub(crate) fn windowed(scores: &[Lane], p: usize) -> Vec<Lane> {
    let window = (2.0 * ((scores.len() / p) as f64).sqrt()).round().max(1.0) as usize;
    let windows = Windows { scores, p, window };
    let share = Lane::splat(1.0 / window as f64);
    pulp::Arch::new().dispatch(windows).finish().square().into_iter().map(|sum| share * sum).collect()
}

/// Products of sums over all windows.
struct Windows<'a> {
    /// Rows of `p`, sample by sample.
    scores: &'a [Lane],
    p: usize,
    window: usize,
}

impl pulp::WithSimd for Windows<'_> {
    type Output = Products;

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) -> Products {
        let Self { scores, p, window } = self;
        let rows = scores.len() / p;
        let mut sum = vec![Lane::ZERO; p];
        let mut products = Products::new(p);
        for k in 0..rows + window {
            if k < rows {
                sum.iter_mut().zip(&scores[k * p..]).for_each(|(sum, g)| *sum += *g);
            }
            if k >= window {
                sum.iter_mut().zip(&scores[(k - window) * p..]).for_each(|(sum, g)| *sum = *sum - *g);
            }
            sum.iter().enumerate().for_each(|(i, sum)| products.set(i, *sum));
            products.advance();
        }
        products
    }
}
