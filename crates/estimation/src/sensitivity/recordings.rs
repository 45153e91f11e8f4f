use std::collections::BTreeMap;

use numerics::{LANES, Lane};
use ship::engine::{RunView, SideBySide};
use ship::model::Model;

use super::unknowns::Unknowns;

/// Recordings of N samples, all row-major: [`LANES`] of them side by side, or a single one (`X` = `f64`). Shorter
/// ones are padded with arbitrary values.
#[derive(Clone, Copy, Debug)]
pub struct Recordings<'a, X = Lane> {
    /// The model structure, with or without intercepts.
    pub model: &'a Model,
    /// Measured states u, v \[m/s\], r \[rad/s\]: (N+1) × 3; empty without measurements.
    pub measured: &'a [X],
    /// Inputs and measured disturbances: N × exogenous.
    pub exogenous: &'a [X],
    /// Initial states.
    pub initial: [X; 3],
    /// Samples of each recording; later ones are ignored.
    pub samples: [usize; LANES],
}

impl<'a> Recordings<'a, f64> {
    /// A run that was not measured.
    pub fn simulated(model: &'a Model, initial: [f64; 3], exogenous: &'a [f64]) -> Self {
        let samples = [exogenous.len() / model.exogenous().max(1); LANES];
        Self { model, measured: &[], exogenous, initial, samples }
    }
}

impl<'a, X: Unknowns> Recordings<'a, X> {
    /// The longest recording's samples N.
    pub fn longest(&self) -> usize {
        self.exogenous.len() / self.model.exogenous().max(1)
    }

    /// Number of unknowns: the model's parameters, then three offsets of the initial state.
    pub fn unknowns(&self) -> usize {
        self.model.parameters() + 3
    }

    /// Inputs and measured disturbances at sample `k`.
    #[inline(always)]
    pub(crate) fn exogenous(&self, k: usize) -> &'a [X] {
        let width = self.model.exogenous();
        &self.exogenous[k * width..(k + 1) * width]
    }

    /// Measured states less `state` at sample `k`; zero without measurements.
    #[inline(always)]
    pub(crate) fn error(&self, k: usize, state: [X; 3]) -> [X; 3] {
        match self.measured.is_empty() {
            true => [X::ZERO; 3],
            false => {
                let measured = &self.measured[3 * k..3 * k + 3];
                [measured[0] - state[0], measured[1] - state[1], measured[2] - state[2]]
            }
        }
    }

    /// 1 for recordings that last to sample `k`, 0 for others.
    #[inline(always)]
    pub fn lasting(&self, k: usize) -> X {
        X::by_lane(|lane| if k <= self.samples[lane] { 1.0 } else { 0.0 })
    }
}

impl<'a> Recordings<'a> {
    /// Recordings of runs in lanes.
    pub fn of(model: &'a Model, runs: &'a SideBySide) -> Self {
        let SideBySide { measured, exogenous, initial, samples, .. } = runs;
        Self { model, measured, exogenous, initial: *initial, samples: *samples }
    }
}

/// Groups the runs at `chosen` by length, with a maximum number per group.
pub(crate) fn of_one_length(
    all: &[RunView],
    chosen: impl Iterator<Item = usize>,
    most: usize,
) -> Vec<Vec<usize>> {
    let mut by_length: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
    chosen.for_each(|run| by_length.entry(all[run].samples()).or_default().push(run));
    by_length.values().flat_map(|runs| runs.chunks(most).map(<[usize]>::to_vec)).collect()
}

/// The runs at `chosen` in groups of up to [`LANES`] of equal length, each in lanes.
pub(crate) fn groups(
    all: &[RunView],
    chosen: impl Iterator<Item = usize>,
) -> impl Iterator<Item = (Vec<usize>, SideBySide)> {
    let groups = of_one_length(all, chosen, LANES);
    groups.into_iter().map(|group| {
        let own: Vec<RunView> = group.iter().map(|run| all[*run]).collect();
        (group, SideBySide::of(&own))
    })
}
