use vessel::{Lane, Tangent};

use super::dynamics::{Dynamics, Local};
use super::levels::{Flow, Levels};
use super::products::Products;
use super::recordings::Recordings;
use super::scores::Kept;

/// What `levels` add to the covariance of Σ sᵀWe beside measurement noise, to first order around the run's simulation: every
/// draw enters the states and goes on with them; adjoints λ(k) = Aᵀλ(k+1) + s(k)ᵀW tell what a change of the states at k
/// does to the scores. free × free lanes.
pub(crate) fn disturbed_scores(
    recordings: &Recordings,
    unknowns: &[Lane],
    kept: &Kept,
    weights: [Lane; 3],
    levels: &Levels,
) -> Vec<Lane> {
    let products = match levels.states() {
        3 => pulp::Arch::new().dispatch(Backward::<3> { recordings, unknowns, kept, weights, levels }),
        5 => pulp::Arch::new().dispatch(Backward::<5> { recordings, unknowns, kept, weights, levels }),
        6 => pulp::Arch::new().dispatch(Backward::<6> { recordings, unknowns, kept, weights, levels }),
        _ => pulp::Arch::new().dispatch(Backward::<8> { recordings, unknowns, kept, weights, levels }),
    };
    products.finish().square()
}

struct Backward<'a, const N: usize> {
    recordings: &'a Recordings<'a>,
    unknowns: &'a [Lane],
    kept: &'a Kept,
    weights: [Lane; 3],
    levels: &'a Levels,
}

impl<const N: usize> pulp::WithSimd for Backward<'_, N> {
    type Output = Products;

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) -> Products {
        let Self { recordings, unknowns, kept, weights, levels } = self;
        let theta = &unknowns[..recordings.model.parameters()];
        let mut dynamics = Dynamics::<N>::new(Tangent::new(recordings.model), Some(levels));
        let width = recordings.model.exogenous();
        let mut adjoints = vec![[Lane::ZERO; N]; kept.free];
        let mut draws = Products::new(kept.free);
        for k in (0..=recordings.longest()).rev() {
            if k < recordings.longest() {
                let mut z = [Lane::ZERO; N];
                z[..3].copy_from_slice(&kept.states[3 * k..3 * k + 3]);
                let local = dynamics.at(&z, &recordings.exogenous[k * width..(k + 1) * width], theta);
                add_draws(&mut draws, &adjoints, &local, levels);
                adjoints.iter_mut().for_each(|a| *a = dynamics.backward(&local, a));
            }
            for (a, s) in adjoints.iter_mut().zip(kept.at(k)) {
                (0..3).for_each(|d| a[d] += weights[d] * s[d]);
            }
        }
        add_start(&mut draws, &adjoints, levels);
        draws
    }
}

/// Adds what the draws between two samples do; `adjoints` are those of the later one.
#[inline(always)]
fn add_draws<const N: usize>(draws: &mut Products, adjoints: &[[Lane; N]], local: &Local, levels: &Levels) {
    match levels.current {
        Flow::Still => {}
        Flow::White { std } => {
            for i in 0..2 {
                let column = local.slopes.each_ref().map(|row| Lane::splat(std) * row[i]);
                for (place, a) in adjoints.iter().enumerate() {
                    draws.set(place, column[0] * a[0] + column[1] * a[1] + column[2] * a[2]);
                }
                draws.advance();
            }
        }
        Flow::Markov { std, factor, .. } => {
            let fresh = std * (1.0 - factor * factor).max(0.0).sqrt();
            (3..5).for_each(|i| add_state(draws, adjoints, i, fresh));
        }
    }
    if let Some(gusts) = levels.gusts() {
        let share = (1.0 - gusts.factor * gusts.factor).sqrt();
        (0..3).for_each(|d| add_state(draws, adjoints, N - 3 + d, gusts.std[d] * share));
    }
}

/// Adds what the disturbances' first values do.
fn add_start<const N: usize>(draws: &mut Products, adjoints: &[[Lane; N]], levels: &Levels) {
    if let Flow::Markov { std, .. } = levels.current {
        (3..5).for_each(|i| add_state(draws, adjoints, i, std));
    }
    if let Some(gusts) = levels.gusts() {
        (0..3).for_each(|d| add_state(draws, adjoints, N - 3 + d, gusts.std[d]));
    }
}

/// Adds what a change of standard deviation `std` in state `i` does.
#[inline(always)]
fn add_state<const N: usize>(draws: &mut Products, adjoints: &[[Lane; N]], i: usize, std: f64) {
    if std > 0.0 {
        let scaled = adjoints.iter().map(|a| Lane::splat(std) * a[i]);
        scaled.enumerate().for_each(|(place, value)| draws.set(place, value));
        draws.advance();
    }
}
