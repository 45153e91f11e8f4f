use numerics::Lane;

use super::dynamics::{Dynamics, Flow, Local, NoiseModel};
use super::kalman::Gain;
use super::products::{Backward, Products};
use super::{Recordings, Unknowns};

/// One pass over recordings: predicts, compares, and propagates the sensitivities. `unknowns`: one number each, as
/// [`Recordings::unknowns`] orders them, then the initial disturbances if not zero; `free`: those whose sensitivities
/// are computed; `levels`: the disturbances, and `gains` of every sample: neither for a free simulation. `each` is
/// called with every sample from 0 to N.
pub(crate) fn sweep<X: Unknowns, const N: usize>(
    recordings: &Recordings<X>,
    unknowns: &[X],
    free: &[usize],
    levels: Option<&NoiseModel<X>>,
    gains: &[Gain<X, N>],
    each: impl FnMut(Step<'_, X, N>),
) {
    let (model, (theta, _)) = (recordings.model, unknowns.split_at(recordings.model.parameters()));
    let dynamics = Dynamics::new(model, theta, levels);
    numerics::vectorized!(narrow: go_along(dynamics, recordings, unknowns, free, gains, each));
}

/// A sweep of free simulations of the vessel's three states, without disturbances and corrections. `unknowns`: the
/// model's parameters, then three offsets of the initial state; `free`: indices of those whose sensitivities are
/// computed. `each` is called with every sample from 0 to N.
pub fn free_sweep<X: Unknowns>(
    recordings: &Recordings<X>,
    unknowns: &[X],
    free: &[usize],
    each: impl FnMut(Step<'_, X, 3>),
) {
    sweep(recordings, unknowns, free, None, &[], each);
}

/// A sweep at a sample, before the correction by the sample's measurement.
pub struct Step<'a, X, const N: usize> {
    /// The sample, from 0 on.
    pub k: usize,
    /// Measured minus predicted u, v \[m/s\], r \[rad/s\].
    pub error: [X; 3],
    /// Predicted states: u, v \[m/s\], r \[rad/s\], then those of disturbances.
    pub states: &'a [X; N],
    /// Columns of ∂(predicted states)/∂(free unknowns).
    pub sensitivities: &'a [[Lane; N]],
}

#[inline(always)]
fn go_along<X: Unknowns, const N: usize>(
    mut dynamics: Dynamics<X, N>,
    recordings: &Recordings<X>,
    unknowns: &[X],
    free: &[usize],
    gains: &[Gain<X, N>],
    mut each: impl FnMut(Step<'_, X, N>),
) {
    let model = recordings.model;
    let offsets = &unknowns[model.parameters()..];
    let mut z = [X::ZERO; N];
    for (d, offset) in offsets.iter().enumerate().take(N) {
        z[d] = if d < 3 { recordings.initial[d] + *offset } else { *offset };
    }
    let mut sensitivities = vec![[Lane::ZERO; N]; free.len().div_ceil(X::PER_COLUMN)];
    // The state that the term of a parameter moves; none of a shift of the initial state.
    let moves: Vec<Option<usize>> = free.iter().map(|i| model.layout().degrees().nth(*i)).collect();
    for (i, unknown) in free.iter().enumerate().filter(|(i, _)| moves[*i].is_none()) {
        X::ONE.add_to(&mut sensitivities[i / X::PER_COLUMN][unknown - model.parameters()], i);
    }
    let last = recordings.longest();
    for k in 0..=last {
        let error = recordings.error(k, [z[0], z[1], z[2]]);
        each(Step { k, error, states: &z, sensitivities: &sensitivities });
        if k == last {
            return;
        }
        let gain = gains.get(k);
        if let Some(gain) = gain {
            gain.correct(&mut z, &error);
        }
        let local = dynamics.at(&z, recordings.exogenous(k));
        z = dynamics.next(&z, &local);
        for s in &mut sensitivities {
            if let Some(gain) = gain {
                gain.correct_column(s);
            }
            *s = dynamics.motion.forward(&local, s);
        }
        for (i, (unknown, d)) in free.iter().zip(&moves).enumerate() {
            if let Some(d) = d {
                dynamics.model.term(*unknown).add_to(&mut sensitivities[i / X::PER_COLUMN][*d], i);
            }
        }
    }
}

/// A free simulation with its sensitivities, sample by sample.
#[derive(Clone, Debug)]
pub struct Sensitivities<X> {
    free: usize,
    /// Measured minus simulated states, (N+1) × 3; zero for samples that do not count.
    pub errors: Vec<X>,
    /// Simulated states, (N+1) × 3.
    pub states: Vec<X>,
    /// By sample the columns of ∂states/∂(free unknowns); zero for samples that do not count.
    columns: Vec<[Lane; 3]>,
}

impl<X> Default for Sensitivities<X> {
    fn default() -> Self {
        Self { free: 0, errors: Vec::new(), states: Vec::new(), columns: Vec::new() }
    }
}

impl<X: Unknowns> Sensitivities<X> {
    /// The sensitivities of `recordings` to unknowns in `free`; sample 0 counts where `from_start`.
    pub fn of(recordings: &Recordings<X>, unknowns: &[X], free: &[usize], from_start: bool) -> Self {
        let mut kept = Self::default();
        kept.follow(recordings, unknowns, free, from_start);
        kept
    }

    /// Simulates other recordings, overwriting the previous ones, see [`Self::of`].
    pub(crate) fn follow(&mut self, recordings: &Recordings<X>, unknowns: &[X], free: &[usize], start: bool) {
        self.clear(free.len(), recordings.longest());
        sweep(
            recordings,
            unknowns,
            free,
            None,
            &[],
            #[inline(always)]
            |step: Step<'_, X, 3>| {
                self.keep(&step, if step.k == 0 && !start { X::ZERO } else { recordings.lasting(step.k) });
            },
        );
    }

    pub(crate) fn clear(&mut self, free: usize, samples: usize) {
        let rows = samples + 1;
        self.free = free;
        for (kept, count) in [(&mut self.errors, 3 * rows), (&mut self.states, 3 * rows)] {
            kept.clear();
            kept.reserve(count);
        }
        self.columns.clear();
        self.columns.reserve(rows * free.div_ceil(X::PER_COLUMN));
    }

    #[inline(always)]
    pub(crate) fn keep(&mut self, step: &Step<'_, X, 3>, counts: X) {
        let [u, v, r] = step.error;
        self.errors.extend_from_slice(&[u * counts, v * counts, r * counts]);
        self.states.extend_from_slice(step.states);
        let counts = counts.lane();
        for [u, v, r] in step.sensitivities {
            self.columns.push([*u * counts, *v * counts, *r * counts]);
        }
    }

    /// Number of free unknowns.
    pub fn free(&self) -> usize {
        self.free
    }

    /// ∂(u, v, r)/∂(free unknown `i`) at sample `k`.
    pub fn by(&self, k: usize, i: usize) -> [X; 3] {
        self.at(k)[i / X::PER_COLUMN].map(|column| X::of_column(column, i))
    }

    pub(crate) fn columns(&self) -> usize {
        self.free.div_ceil(X::PER_COLUMN)
    }

    #[inline(always)]
    pub(crate) fn at(&self, k: usize) -> &[[Lane; 3]] {
        &self.columns[k * self.columns()..(k + 1) * self.columns()]
    }

    #[inline(always)]
    pub(crate) fn state(&self, k: usize) -> &[X; 3] {
        &self.states.as_chunks().0[k]
    }
}

/// The backward pass over `path`: adjoints λ(k) = Aᵀλ(k+1) + W s(k) are the derivatives of Σ sᵀWx by the states at k.
/// `between` is called for k from N − 1 to 0 with λ(k+1); λ(0) is returned.
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
                slopes = Some(local.slopes.map(|slope| slope.map(X::lane)));
            } else {
                adjoints.iter_mut().for_each(|a| *a = dynamics.motion.backward(&local, a));
            }
        }
        let sensitivities = path.at(k);
        numerics::dispatch_narrow(Backward { slopes, weights, sensitivities, adjoints: &mut adjoints });
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

pub(crate) fn add_start<X: Unknowns, const N: usize>(
    draws: &mut Products<X>,
    adjoints: &[[Lane; N]],
    levels: &NoiseModel,
) {
    let all = levels.spread::<f64>().processes::<N>();
    let measured = levels.drift.is_some();
    all.for_each(|(i, std, _)| add_state(draws, adjoints, i, std, measured));
}

/// Adds the effect of a change `std` in state `i`; that of a sensor's drift is `measured` at once.
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
