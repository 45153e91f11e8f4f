use vessel::{Lane, Tangent};

use super::dynamics::Dynamics;
use super::kalman::Gain;
use super::levels::Levels;
use super::recordings::Recordings;

/// One pass over recordings: predicts, compares, and carries the sensitivities along. `unknowns`: one lane each, as
/// [`Recordings::unknowns`] orders them; `free`: those whose sensitivities are wanted; `levels`: what disturbs, and `gains`
/// of every sample: neither for a free simulation. `each` is called with every sample from 0 to N.
pub(crate) fn sweep<const N: usize>(
    recordings: &Recordings,
    unknowns: &[Lane],
    free: &[usize],
    levels: Option<&Levels>,
    gains: &[Gain<N>],
    each: impl FnMut(Step<'_, N>),
) {
    pulp::Arch::new().dispatch(Sweep { recordings, unknowns, free, levels, gains, each });
}

/// [`sweep`] compiled for every instruction set that pulp picks from. Lanes are only added and multiplied, never fused, so
/// that all give the same bits.
struct Sweep<'a, F, const N: usize> {
    recordings: &'a Recordings<'a>,
    unknowns: &'a [Lane],
    free: &'a [usize],
    levels: Option<&'a Levels>,
    gains: &'a [Gain<N>],
    each: F,
}

/// What a sweep finds at a sample, before the sample's measurement corrects it.
pub(crate) struct Step<'a, const N: usize> {
    pub k: usize,
    /// Measured minus predicted.
    pub error: [Lane; 3],
    /// Predicted states.
    pub states: &'a [Lane; N],
    /// ∂(predicted states)/∂(free unknowns).
    pub sensitivities: &'a [[Lane; N]],
}

impl<F: FnMut(Step<'_, N>), const N: usize> pulp::WithSimd for Sweep<'_, F, N> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) {
        let Self { recordings, unknowns, free, levels, gains, mut each } = self;
        let model = recordings.model;
        let (theta, rest) = unknowns.split_at(model.parameters());
        let (intercepts, offsets) = rest.split_at(3);
        let mut dynamics = Dynamics::<N>::new(Tangent::new(model), levels);
        let mut z = [Lane::ZERO; N];
        (0..3).for_each(|d| z[d] = recordings.initial[d] + offsets[d]);
        let mut sensitivities = vec![[Lane::ZERO; N]; free.len()];
        let effects: Vec<Effect> =
            free.iter().map(|i| Effect::of(*i, theta.len(), dynamics.tangent())).collect();
        for (s, effect) in sensitivities.iter_mut().zip(&effects) {
            if let Effect::Initial(d) = effect {
                s[*d] = Lane::ONE;
            }
        }
        let width = model.exogenous();
        let last = recordings.longest();
        for k in 0..=last {
            let error = [0, 1, 2].map(|d: usize| recordings.measured[3 * k + d] - z[d]);
            each(Step { k, error, states: &z, sensitivities: &sensitivities });
            if k == last {
                return;
            }
            let gain = gains.get(k);
            if let Some(gain) = gain {
                gain.correct(&mut z, &error);
            }
            let exogenous = &recordings.exogenous[k * width..(k + 1) * width];
            let local = dynamics.at(&z, exogenous, theta);
            z = dynamics.next(&z, &local, theta, intercepts);
            for (s, effect) in sensitivities.iter_mut().zip(&effects) {
                if let Some(gain) = gain {
                    let known = [s[0], s[1], s[2]].map(|x| Lane::ZERO - x);
                    gain.correct(s, &known);
                }
                *s = dynamics.forward(&local, s);
                match effect {
                    Effect::Term(i, d) => s[*d] += dynamics.tangent().term(*i),
                    Effect::Intercept(d) => s[*d] += Lane::ONE,
                    Effect::Initial(_) => {}
                }
            }
        }
    }
}

/// What an unknown does to the next state.
enum Effect {
    /// Multiplies its term in this degree of freedom.
    Term(usize, usize),
    /// Is added to this state.
    Intercept(usize),
    /// Shifts this state once, at the start.
    Initial(usize),
}

impl Effect {
    fn of(unknown: usize, parameters: usize, tangent: &Tangent) -> Self {
        match unknown.checked_sub(parameters) {
            None => Self::Term(unknown, tangent.degree(unknown)),
            Some(d @ 0..3) => Self::Intercept(d),
            Some(d) => Self::Initial(d - 3),
        }
    }
}

/// Predictions of recordings and their sensitivities, sample by sample, as [`sensitivities`] keeps them.
#[derive(Clone, Debug, PartialEq)]
pub struct Sensitivities {
    /// Simulated states: (N+1) × 3.
    pub states: Vec<Lane>,
    /// ∂states/∂(free unknowns): (N+1) × free × 3.
    pub derivatives: Vec<Lane>,
}

/// Simulates `recordings` freely with `unknowns`, and the sensitivities to those in `free`.
pub fn sensitivities(recordings: &Recordings, unknowns: &[Lane], free: &[usize]) -> Sensitivities {
    let rows = recordings.longest() + 1;
    let mut found = Sensitivities {
        states: Vec::with_capacity(3 * rows),
        derivatives: Vec::with_capacity(3 * rows * free.len()),
    };
    sweep(
        recordings,
        unknowns,
        free,
        None,
        &[],
        #[inline(always)]
        |step: Step<'_, 3>| {
            found.states.extend_from_slice(step.states);
            step.sensitivities.iter().for_each(|s| found.derivatives.extend_from_slice(s));
        },
    );
    found
}
