use std::collections::BTreeMap;

use vessel::{LANES, Lane, Model};

/// One run of N samples, row-major.
#[derive(Clone, Copy, Debug)]
pub struct Recording<'a> {
    /// Measured states u, v \[m/s\], r \[rad/s\]: (N+1) × 3.
    pub measured: &'a [f64],
    /// Inputs and measured disturbances: N × exogenous.
    pub exogenous: &'a [f64],
    /// State that it starts from.
    pub initial: [f64; 3],
}

impl Recording<'_> {
    /// Number of samples N.
    pub fn samples(&self) -> usize {
        self.measured.len() / 3 - 1
    }
}

/// [`LANES`] recordings side by side, all row-major, of N samples; shorter ones are filled up with anything.
#[derive(Clone, Copy, Debug)]
pub struct Recordings<'a> {
    /// The model structure.
    pub model: &'a Model,
    /// Measured states u, v \[m/s\], r \[rad/s\]: (N+1) × 3.
    pub measured: &'a [Lane],
    /// Inputs and measured disturbances: N × exogenous.
    pub exogenous: &'a [Lane],
    /// State that each starts from.
    pub initial: [Lane; 3],
    /// Samples of each recording; what comes later counts for nothing.
    pub samples: [usize; LANES],
}

impl Recordings<'_> {
    /// The longest recording's samples N.
    pub fn longest(&self) -> usize {
        self.measured.len() / 3 - 1
    }

    /// Number of unknowns: parameters (surge, sway, yaw), three intercepts, three offsets of the initial state.
    pub fn unknowns(&self) -> usize {
        self.model.parameters() + 6
    }

    /// 1 for recordings that last to sample `k`, 0 for others.
    #[inline(always)]
    pub(crate) fn lasting(&self, k: usize) -> Lane {
        Lane(std::array::from_fn(|lane| if k <= self.samples[lane] { 1.0 } else { 0.0 }))
    }
}

/// Up to [`LANES`] runs of equal length, side by side; lanes that are left repeat the last run.
pub(crate) struct SideBySide<'a> {
    model: &'a Model,
    measured: Vec<Lane>,
    exogenous: Vec<Lane>,
    initial: [Lane; 3],
    samples: usize,
}

impl<'a> SideBySide<'a> {
    /// The runs at `chosen` of `all`.
    pub(crate) fn of(model: &'a Model, all: &[Recording], chosen: &[usize]) -> Self {
        let own: [&Recording; LANES] = by_lane(chosen, |run| &all[run]);
        Self {
            model,
            measured: interleave(own.map(|run| run.measured)),
            exogenous: interleave(own.map(|run| run.exogenous)),
            initial: [0, 1, 2].map(|d: usize| Lane(own.map(|run| run.initial[d]))),
            samples: own[0].samples(),
        }
    }

    /// As a predictor takes them.
    pub(crate) fn recordings(&self) -> Recordings<'_> {
        Recordings {
            model: self.model,
            measured: &self.measured,
            exogenous: &self.exogenous,
            initial: self.initial,
            samples: [self.samples; LANES],
        }
    }
}

fn interleave(rows: [&[f64]; LANES]) -> Vec<Lane> {
    (0..rows[0].len()).map(|i| Lane(rows.map(|row| row[i]))).collect()
}

/// What belongs to each lane when the runs at `chosen` stand side by side.
pub(crate) fn by_lane<T>(chosen: &[usize], mut of: impl FnMut(usize) -> T) -> [T; LANES] {
    std::array::from_fn(|lane| of(chosen[lane.min(chosen.len() - 1)]))
}

/// The runs at `chosen` in groups of up to [`LANES`] of equal length.
pub(crate) fn groups(all: &[Recording], chosen: impl Iterator<Item = usize>) -> Vec<Vec<usize>> {
    let mut by_length: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
    chosen.for_each(|run| by_length.entry(all[run].samples()).or_default().push(run));
    by_length.values().flat_map(|runs| runs.chunks(LANES).map(<[usize]>::to_vec)).collect()
}
