use numerics::{LANES, Lane};

use crate::sensitivity::{Gain, NoiseModel, Products, Recordings, Sensitivities, Step, sweep};

/// Sums of squares and products of errors e and sensitivities s = ∂x̂/∂(unknown), per state u, v, r.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Linear {
    /// Number of samples.
    pub samples: f64,
    /// Σ e².
    pub squares: [f64; 3],
    /// Σ s e, an entry per free unknown.
    pub gradient: [Vec<f64>; 3],
    /// Σ s sᵀ, free × free row-major.
    pub normal: [Vec<f64>; 3],
}

impl Linear {
    /// Adds other samples.
    pub(crate) fn add(&mut self, other: &Self) {
        self.samples += other.samples;
        for d in 0..3 {
            self.squares[d] += other.squares[d];
            let pairs = self.gradient[d].iter_mut().zip(&other.gradient[d]);
            pairs.for_each(|(a, b)| *a += b);
            self.normal[d].iter_mut().zip(&other.normal[d]).for_each(|(a, b)| *a += b);
        }
    }

    /// Whether every number is finite.
    pub(crate) fn finite(&self) -> bool {
        self.squares.iter().chain(self.normal.iter().flatten()).all(|x| x.is_finite())
    }

    /// Σ_d w_d (Σ s sᵀ, Σ s e).
    pub(crate) fn weighted(&self, weights: [f64; 3]) -> (Vec<f64>, Vec<f64>) {
        let mix = |parts: &[Vec<f64>; 3]| -> Vec<f64> {
            (0..parts[0].len()).map(|i| (0..3).map(|d| weights[d] * parts[d][i]).sum()).collect()
        };
        (mix(&self.normal), mix(&self.gradient))
    }
}

/// Linearises predictions at `unknowns`: the terms of the sum of squared errors and of its Gauss–Newton step, per
/// lane. With gains errors and sensitivities are whitened. Sample 0 counts where `from_start`.
pub(crate) fn linearize<const N: usize>(
    recordings: &Recordings,
    unknowns: &[Lane],
    free: &[usize],
    levels: Option<&NoiseModel>,
    gains: &[Gain<Lane, N>],
    from_start: bool,
) -> Vec<Linear> {
    let levels = levels.map(NoiseModel::spread);
    linearize_each(recordings, unknowns, free, levels.as_ref(), gains, from_start)
}

/// The same with levels of every recording.
pub(crate) fn linearize_each<const N: usize>(
    recordings: &Recordings,
    unknowns: &[Lane],
    free: &[usize],
    levels: Option<&NoiseModel<Lane>>,
    gains: &[Gain<Lane, N>],
    from_start: bool,
) -> Vec<Linear> {
    let longest = recordings.longest();
    let even = recordings.samples.iter().all(|n| *n == longest);
    let mut products = [0; 3].map(|_| Products::<Lane>::new(free.len() + 1));
    sweep(
        recordings,
        unknowns,
        free,
        levels,
        gains,
        #[inline(always)]
        |step: Step<'_, Lane, N>| {
            if step.k == 0 && !from_start {
                return;
            }
            let (gain, mask) = (gains.get(step.k), (!even).then(|| recordings.lasting(step.k)));
            if gain.is_none() && mask.is_none() {
                for (d, products) in products.iter_mut().enumerate() {
                    products.scale(step.sensitivities, d, Lane::ONE);
                }
            } else {
                for (i, s) in step.sensitivities.iter().enumerate() {
                    set(&mut products, i, [s[0], s[1], s[2]], gain, mask);
                }
            }
            set(&mut products, free.len(), step.error, gain, mask);
            for products in &mut products {
                products.advance();
            }
        },
    );
    linears(products, recordings, from_start)
}

/// The same for free simulations, which are `kept`.
pub(crate) fn linearize_and_keep(
    recordings: &Recordings,
    unknowns: &[Lane],
    free: &[usize],
    from_start: bool,
    kept: &mut Sensitivities<Lane>,
) -> Vec<Linear> {
    let mut products = [0; 3].map(|_| Products::<Lane>::new(free.len() + 1));
    kept.clear(free.len(), recordings.longest());
    sweep(
        recordings,
        unknowns,
        free,
        None,
        &[],
        #[inline(always)]
        |step: Step<'_, Lane, 3>| {
            if step.k == 0 && !from_start {
                return kept.keep(&step, Lane::ZERO);
            }
            let counts = recordings.lasting(step.k);
            kept.keep(&step, counts);
            for (d, products) in products.iter_mut().enumerate() {
                products.scale(step.sensitivities, d, counts);
                products.set(free.len(), step.error[d] * counts);
                products.advance();
            }
        },
    );
    linears(products, recordings, from_start)
}

/// Per lane, from sums of sensitivities and, last, errors.
pub(super) fn linears(
    products: [Products<Lane>; 3],
    recordings: &Recordings,
    from_start: bool,
) -> Vec<Linear> {
    let sums = products.map(|products| products.finish().square());
    let first = usize::from(!from_start);
    let p = sums[0].len().isqrt() - 1;
    let rows = |d: usize| sums[d].chunks_exact(p + 1);
    let linear = |lane: usize| Linear {
        samples: (recordings.samples[lane] + 1 - first) as f64,
        squares: [0, 1, 2].map(|d: usize| sums[d][p * (p + 1) + p][lane]),
        gradient: [0, 1, 2].map(|d: usize| rows(d).take(p).map(|row| row[p][lane]).collect()),
        normal: [0, 1, 2]
            .map(|d: usize| rows(d).take(p).flat_map(|row| &row[..p]).map(|sum| sum[lane]).collect()),
    };
    (0..LANES).map(linear).collect()
}

/// Sets signal `i` of every state, whitened with a gain, times `mask`.
#[inline(always)]
fn set<const N: usize>(
    products: &mut [Products<Lane>; 3],
    i: usize,
    signal: [Lane; 3],
    gain: Option<&Gain<Lane, N>>,
    mask: Option<Lane>,
) {
    let white = match gain {
        Some(gain) => gain.white(&signal),
        None => signal,
    };
    for (d, products) in products.iter_mut().enumerate() {
        products.set(i, if let Some(mask) = mask { white[d] * mask } else { white[d] });
    }
}
