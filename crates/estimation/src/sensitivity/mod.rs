//! Sensitivities of simulated and predicted states to the unknowns: the common engine of estimates, their standard
//! errors, the information of experiments and its gradient.
//!
//! [`Dynamics`] advances the states sample by sample; [`sweep`] propagates forward sensitivities with them, and
//! [`backward`] adjoints. Both are
//! columns of lanes. Numbers `X` are [`numerics::Lane`]s for runs in lanes, each unknown in its own column; or `f64`
//! for a single run, with [`numerics::LANES`] unknowns in a column ([`Unknowns`]).

mod dynamics;
mod information;
mod kalman;
mod products;
mod sweep;

use std::collections::BTreeMap;

use numerics::{LANES, Lane, Number};
use ship::engine::{RunView, SideBySide, Stepping};
use ship::model::Model;

pub use dynamics::{Drift, Flow, ForceNoise, NoiseModel};
pub(crate) use dynamics::{Dynamics, Local, Motion, current_of, vessel_state, with_states};
pub use information::{
    OutputInformation, Simulated, output_information, output_informations, prediction_weights, state_slopes,
    summed_information,
};
pub(crate) use information::{RunInformation, channels};
pub(crate) use kalman::{Gain, add_noise, filter, filter_along, gain, moved, shrink, start};
pub(crate) use products::Products;
pub use sweep::{Sensitivities, Step, free_sweep};
pub(crate) use sweep::{add_draws, add_start, backward, sweep};

/// Recordings of N samples, row-major: [`LANES`] side by side, or a single one (`X` = `f64`); padded if shorter.
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
pub(crate) fn of_one_length(all: &[RunView], at: impl Iterator<Item = usize>, max: usize) -> Vec<Vec<usize>> {
    let mut by_length: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
    at.for_each(|run| by_length.entry(all[run].samples()).or_default().push(run));
    by_length.values().flat_map(|runs| runs.chunks(max).map(<[usize]>::to_vec)).collect()
}

/// The runs at `chosen` in groups of up to [`LANES`] of equal length, each in lanes.
pub(crate) fn groups(
    all: &[RunView],
    chosen: impl Iterator<Item = usize>,
) -> impl Iterator<Item = (Vec<usize>, SideBySide)> {
    let groups = of_one_length(all, chosen, LANES);
    groups.into_iter().map(|group| {
        let views: Vec<RunView> = group.iter().map(|run| all[*run]).collect();
        (group, SideBySide::of(&views))
    })
}

/// The layout of unknowns in columns of lanes.
pub trait Unknowns: Number + Stepping {
    /// Unknowns per column.
    const PER_COLUMN: usize;
    /// The entry of unknown `i` in its column.
    fn of_column(column: Lane, i: usize) -> Self;
    /// Adds to the entry of unknown `i` in its column.
    fn add_to(self, column: &mut Lane, i: usize);
    /// A number of every run; of the first for a single run.
    fn by_lane(of: impl Fn(usize) -> f64) -> Self;
}

impl Unknowns for Lane {
    const PER_COLUMN: usize = 1;
    #[inline(always)]
    fn of_column(column: Lane, _: usize) -> Self {
        column
    }
    #[inline(always)]
    fn add_to(self, column: &mut Lane, _: usize) {
        *column += self;
    }
    #[inline(always)]
    fn by_lane(of: impl Fn(usize) -> f64) -> Self {
        let mut lanes = Self::ZERO;
        for (lane, entry) in lanes.0.iter_mut().enumerate() {
            *entry = of(lane);
        }
        lanes
    }
}

impl Unknowns for f64 {
    const PER_COLUMN: usize = LANES;
    #[inline(always)]
    fn of_column(column: Lane, i: usize) -> Self {
        column[i % LANES]
    }
    #[inline(always)]
    fn add_to(self, column: &mut Lane, i: usize) {
        column[i % LANES] += self;
    }
    #[inline(always)]
    fn by_lane(of: impl Fn(usize) -> f64) -> Self {
        of(0)
    }
}
