use numerics::Lane;
use ship::model::Model;

use super::dynamics::Dynamics;
use super::kalman::Gain;
use super::levels::NoiseModel;
use super::recordings::Recordings;
use super::unknowns::Unknowns;

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
    let effects: Vec<Effect> = free.iter().map(|i| Effect::of(*i, model)).collect();
    for (i, effect) in effects.iter().enumerate() {
        if let Effect::Initial(d) = effect {
            X::ONE.add_to(&mut sensitivities[i / X::PER_COLUMN][*d], i);
        }
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
            *s = dynamics.forward(&local, s);
        }
        for (i, effect) in effects.iter().enumerate() {
            if let Effect::Term(parameter, d) = effect {
                dynamics.term(*parameter).add_to(&mut sensitivities[i / X::PER_COLUMN][*d], i);
            }
        }
    }
}

/// The effect of an unknown on the next state.
enum Effect {
    /// Multiplies its term in this degree of freedom.
    Term(usize, usize),
    /// Shifts this state once, at the start.
    Initial(usize),
}

impl Effect {
    fn of(unknown: usize, model: &Model) -> Self {
        match model.layout().degrees().nth(unknown) {
            Some(d) => Self::Term(unknown, d),
            None => Self::Initial(unknown - model.parameters()),
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
    /// The sensitivities of `recordings` simulated with `unknowns`, to those in `free`. Sample 0 counts where
    /// `from_start`.
    pub fn of(recordings: &Recordings<X>, unknowns: &[X], free: &[usize], from_start: bool) -> Self {
        let mut kept = Self::default();
        kept.follow(recordings, unknowns, free, from_start);
        kept
    }

    /// Simulates other recordings, overwriting the previous ones, see [`Self::of`].
    pub(crate) fn follow(
        &mut self,
        recordings: &Recordings<X>,
        unknowns: &[X],
        free: &[usize],
        from_start: bool,
    ) {
        self.clear(free.len(), recordings.longest());
        sweep(
            recordings,
            unknowns,
            free,
            None,
            &[],
            #[inline(always)]
            |step: Step<'_, X, 3>| {
                self.keep(
                    &step,
                    if step.k == 0 && !from_start { X::ZERO } else { recordings.lasting(step.k) },
                );
            },
        );
    }

    /// Clears and reserves buffers for other recordings.
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

    /// Stores a sample with the weight `counts`.
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

    /// Number of columns.
    pub(crate) fn columns(&self) -> usize {
        self.free.div_ceil(X::PER_COLUMN)
    }

    /// The columns of sample `k`.
    #[inline(always)]
    pub(crate) fn at(&self, k: usize) -> &[[Lane; 3]] {
        &self.columns[k * self.columns()..(k + 1) * self.columns()]
    }

    /// The states at sample `k`.
    #[inline(always)]
    pub(crate) fn state(&self, k: usize) -> &[X; 3] {
        &self.states.as_chunks().0[k]
    }
}
