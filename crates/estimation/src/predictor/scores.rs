use numerics::Lane;
use regression::BLOCKS;

use super::sums::{Linear, linears};
use crate::sensitivity::{
    Gain, NoiseModel, Products, Recordings, Sensitivities, Step, add_draws, add_start, backward, sweep,
};

/// Sums over each of ten blocks of samples, by block and lane, of recordings predicted with `unknowns`, by the `free`
/// ones: free simulations, in a current of `levels` that is among the unknowns, or white innovations if there are
/// gains. Sample 0 counts where `from_start`.
pub(crate) fn blocks<const N: usize>(
    recordings: &Recordings,
    unknowns: &[Lane],
    free: &[usize],
    levels: Option<&NoiseModel>,
    gains: &[Gain<Lane, N>],
    from_start: bool,
) -> Vec<Vec<Linear>> {
    let (rows, columns) = (recordings.longest() + 1, free.len() + 1);
    let new = || [0; 3].map(|_| Products::<Lane>::new(columns));
    let (mut products, mut found) = (new(), Vec::new());
    sweep(
        recordings,
        unknowns,
        free,
        levels.map(NoiseModel::spread).as_ref(),
        gains,
        |step: Step<'_, Lane, N>| {
            let counts = if step.k == 0 && !from_start { Lane::ZERO } else { recordings.lasting(step.k) };
            let white = |x: [Lane; 3]| {
                let own = gains.get(step.k).map_or(x, |gain| gain.white(&x));
                own.map(|x| x * counts)
            };
            let all = step.sensitivities.iter().map(|s| [s[0], s[1], s[2]]).chain([step.error]);
            for (i, own) in all.map(white).enumerate() {
                (0..3).for_each(|d| products[d].set(i, own[d]));
            }
            products.iter_mut().for_each(Products::advance);
            if (step.k + 1) * BLOCKS / rows > step.k * BLOCKS / rows {
                let full = std::mem::replace(&mut products, new());
                found.push(linears(full, recordings, from_start));
            }
        },
    );
    found
}

/// The contribution of `levels` to the covariance of Σ sᵀWe in addition to measurement noise, to first order about
/// the run's simulation: every draw enters the states and propagates with them; adjoints are the derivatives of the
/// scores by the states. free × free lanes.
pub(crate) fn disturbed_scores<const N: usize>(
    recordings: &Recordings,
    unknowns: &[Lane],
    kept: &Sensitivities<Lane>,
    weights: [Lane; 3],
    levels: &NoiseModel,
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
