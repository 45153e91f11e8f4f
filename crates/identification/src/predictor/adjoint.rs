use vessel::{Lane, Tangent};

use super::dynamics::{Dynamics, Local};
use super::levels::{Flow, Levels};
use super::recordings::Recordings;
use super::scores::{Kept, add_products};

/// Covariance of Σ sᵀWe where `levels` disturb the run, to first order around its simulation: measurement noise enters a
/// sample's error as it is, every other draw enters the states and goes on with them; adjoints λ(k) = Aᵀλ(k+1) + s(k)ᵀW
/// tell what a change of the states at k does to the scores. free × free lanes.
pub(crate) fn disturbed_scores(
    recordings: &Recordings,
    unknowns: &[Lane],
    kept: &Kept,
    weights: [Lane; 3],
    levels: &Levels,
) -> Vec<Lane> {
    match levels.states() {
        3 => pulp::Arch::new().dispatch(Backward::<3> { recordings, unknowns, kept, weights, levels }),
        5 => pulp::Arch::new().dispatch(Backward::<5> { recordings, unknowns, kept, weights, levels }),
        6 => pulp::Arch::new().dispatch(Backward::<6> { recordings, unknowns, kept, weights, levels }),
        _ => pulp::Arch::new().dispatch(Backward::<8> { recordings, unknowns, kept, weights, levels }),
    }
}

struct Backward<'a, const N: usize> {
    recordings: &'a Recordings<'a>,
    unknowns: &'a [Lane],
    kept: &'a Kept,
    weights: [Lane; 3],
    levels: &'a Levels,
}

impl<const N: usize> pulp::WithSimd for Backward<'_, N> {
    type Output = Vec<Lane>;

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) -> Vec<Lane> {
        let Self { recordings, unknowns, kept, weights, levels } = self;
        let theta = &unknowns[..recordings.model.parameters()];
        let mut dynamics = Dynamics::<N>::new(Tangent::new(recordings.model), Some(levels));
        let width = recordings.model.exogenous();
        let noise = levels.measurement.map(Lane::splat);
        let mut adjoints = vec![[Lane::ZERO; N]; kept.free];
        let mut middle = vec![Lane::ZERO; kept.free * kept.free];
        let mut draw = vec![Lane::ZERO; kept.free];
        for k in (0..=recordings.longest()).rev() {
            if k < recordings.longest() {
                let mut z = [Lane::ZERO; N];
                z[..3].copy_from_slice(&kept.states[3 * k..3 * k + 3]);
                let local = dynamics.at(&z, &recordings.exogenous[k * width..(k + 1) * width], theta);
                add_draws(&mut middle, &mut draw, &adjoints, &local, levels);
                adjoints.iter_mut().for_each(|a| *a = dynamics.backward(&local, a));
            }
            let sensitivities = kept.at(k);
            for d in 0..3 {
                for ((a, draw), s) in adjoints.iter_mut().zip(&mut draw).zip(sensitivities) {
                    let weighted = weights[d] * s[d];
                    a[d] += weighted;
                    *draw = noise[d] * weighted;
                }
                add_products(&mut middle, &draw, Lane::ONE);
            }
        }
        add_start(&mut middle, &mut draw, &adjoints, levels);
        middle
    }
}

/// Adds what the draws between two samples do; `adjoints` are those of the later one.
#[inline(always)]
fn add_draws<const N: usize>(
    middle: &mut [Lane],
    draw: &mut [Lane],
    adjoints: &[[Lane; N]],
    local: &Local,
    levels: &Levels,
) {
    match levels.current {
        Flow::Still => {}
        Flow::White { std } => {
            for i in 0..2 {
                let column = local.slopes.each_ref().map(|row| Lane::splat(std) * row[i]);
                for (draw, a) in draw.iter_mut().zip(adjoints) {
                    *draw = column[0] * a[0] + column[1] * a[1] + column[2] * a[2];
                }
                add_products(middle, draw, Lane::ONE);
            }
        }
        Flow::Markov { std, factor, .. } => {
            let fresh = std * (1.0 - factor * factor).max(0.0).sqrt();
            (3..5).for_each(|i| add_state(middle, draw, adjoints, i, fresh));
        }
    }
    if let Some(gusts) = levels.gusts() {
        let share = (1.0 - gusts.factor * gusts.factor).sqrt();
        (0..3).for_each(|d| add_state(middle, draw, adjoints, N - 3 + d, gusts.std[d] * share));
    }
}

/// Adds what the disturbances' first values do.
fn add_start<const N: usize>(
    middle: &mut [Lane],
    draw: &mut [Lane],
    adjoints: &[[Lane; N]],
    levels: &Levels,
) {
    if let Flow::Markov { std, .. } = levels.current {
        (3..5).for_each(|i| add_state(middle, draw, adjoints, i, std));
    }
    if let Some(gusts) = levels.gusts() {
        (0..3).for_each(|d| add_state(middle, draw, adjoints, N - 3 + d, gusts.std[d]));
    }
}

/// Adds what a change of standard deviation `std` in state `i` does.
#[inline(always)]
fn add_state<const N: usize>(
    middle: &mut [Lane],
    draw: &mut [Lane],
    adjoints: &[[Lane; N]],
    i: usize,
    std: f64,
) {
    if std > 0.0 {
        draw.iter_mut().zip(adjoints).for_each(|(draw, a)| *draw = Lane::splat(std) * a[i]);
        add_products(middle, draw, Lane::ONE);
    }
}
