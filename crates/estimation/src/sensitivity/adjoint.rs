use numerics::Lane;

use super::columns::Backward;
use super::dynamics::{Dynamics, Local};
use super::levels::{Flow, NoiseModel};
use super::products::Products;
use super::recordings::Recordings;
use super::sweep::Sensitivities;
use super::unknowns::Unknowns;

/// The backward pass over `path`, the simulation of `recordings` with `unknowns`: adjoints λ(k) = Aᵀλ(k+1) + W s(k),
/// a column each, are the derivatives of Σ sᵀWx by the states at k. `between` is called for k from N − 1 to 0 with
/// the dynamics at k and λ(k+1); λ(0) is returned.
pub(crate) fn backward<X: Unknowns, const N: usize>(
    recordings: &Recordings<X>,
    unknowns: &[X],
    path: &Sensitivities<X>,
    weights: [X; 3],
    levels: Option<&NoiseModel>,
    between: impl FnMut(&Local<X>, &[[Lane; N]]),
) -> Vec<[Lane; N]> {
    let (model, (theta, _)) = (recordings.model, unknowns.split_at(recordings.model.parameters()));
    let spread = levels.map(NoiseModel::spread);
    let dynamics = Dynamics::new(model, theta, spread.as_ref());
    numerics::vectorized!(narrow: backward_pass(dynamics, recordings, path, weights, between))
}

#[inline(always)]
fn backward_pass<X: Unknowns, const N: usize>(
    mut dynamics: Dynamics<X, N>,
    recordings: &Recordings<X>,
    path: &Sensitivities<X>,
    weights: [X; 3],
    mut between: impl FnMut(&Local<X>, &[[Lane; N]]),
) -> Vec<[Lane; N]> {
    let weights = weights.map(X::lane);
    let mut adjoints = vec![[Lane::ZERO; N]; path.columns()];
    for k in (0..=recordings.longest()).rev() {
        let mut slopes = None;
        if k < recordings.longest() {
            let mut z = [X::ZERO; N];
            z[..3].copy_from_slice(path.state(k));
            let local = dynamics.at(&z, recordings.exogenous(k));
            between(&local, &adjoints);
            if N == 3 {
                slopes = Some(local.slopes.map(|own| own.map(X::lane)));
            } else {
                adjoints.iter_mut().for_each(|a| *a = dynamics.backward(&local, a));
            }
        }
        Backward { slopes, weights, sensitivities: path.at(k), adjoints: &mut adjoints }.go();
    }
    adjoints
}

/// Adds the effect of the draws between two samples; `adjoints` are those of the later one.
#[inline(always)]
pub(crate) fn add_draws<X: Unknowns, const N: usize>(
    draws: &mut Products<X>,
    adjoints: &[[Lane; N]],
    local: &Local<X>,
    levels: &NoiseModel,
) {
    if let Flow::White { std } = levels.current {
        for i in 0..2 {
            let [surge, sway, yaw] = &local.slopes;
            let std = X::from(std);
            let (by_u, by_v, by_r) = (std * surge[i], std * sway[i], std * yaw[i]);
            draws.weigh(adjoints, [by_u, by_v, by_r].map(X::lane));
            draws.advance();
        }
    }
    let measured = levels.drift.is_some();
    for (i, std, factor) in levels.spread::<f64>().processes::<N>() {
        add_state(draws, adjoints, i, std * (1.0 - factor * factor).max(0.0).sqrt(), measured);
    }
}

/// Adds the effect of the disturbances' first values.
pub(crate) fn add_start<X: Unknowns, const N: usize>(
    draws: &mut Products<X>,
    adjoints: &[[Lane; N]],
    levels: &NoiseModel,
) {
    let all = levels.spread::<f64>().processes::<N>();
    let measured = levels.drift.is_some();
    all.for_each(|(i, std, _)| add_state(draws, adjoints, i, std, measured));
}

/// Adds the effect of a change of standard deviation `std` in state `i`; that of a sensor's drift is `measured` at
/// once.
#[inline(always)]
fn add_state<X: Unknowns, const N: usize>(
    draws: &mut Products<X>,
    adjoints: &[[Lane; N]],
    i: usize,
    std: f64,
    measured: bool,
) {
    if std <= 0.0 {
        return;
    }
    if measured {
        for (column, adjoint) in adjoints.iter().enumerate() {
            draws.set(column, Lane::splat(std) * (adjoint[i + 3 - N] + adjoint[i]));
        }
    } else {
        draws.scale(adjoints, i, Lane::splat(std));
    }
    draws.advance();
}
