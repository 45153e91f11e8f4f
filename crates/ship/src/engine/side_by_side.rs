use numerics::lanes::{by_lane, interleave_into, lane};
use numerics::{LANES, Lane};

use crate::engine::RunView;

/// Up to [`LANES`] runs in lanes, all row-major, as long as the longest of them.
#[derive(Clone, Debug, Default)]
pub struct SideBySide {
    /// How many runs there are.
    pub runs: usize,
    /// Measured states: (N+1) × 3.
    pub measured: Vec<Lane>,
    /// Inputs and measured disturbances: N × exogenous.
    pub exogenous: Vec<Lane>,
    /// Those that instruments are simulated with, N × exogenous; empty where all are the recorded ones.
    pub instrument_exogenous: Vec<Lane>,
    /// State that simulations start from.
    pub initial: [Lane; 3],
    /// Samples of each run.
    pub samples: [usize; LANES],
}

impl SideBySide {
    /// What instruments are simulated with: N × exogenous.
    pub fn instrument_exogenous(&self) -> &[Lane] {
        if self.instrument_exogenous.is_empty() { &self.exogenous } else { &self.instrument_exogenous }
    }

    /// Packs `runs`; idle lanes repeat the last one.
    pub fn of(runs: &[RunView]) -> Self {
        let mut of = Self::default();
        of.fill(runs);
        of
    }

    /// Replaces the runs by `runs`.
    pub fn fill(&mut self, runs: &[RunView]) {
        let rows = |of: for<'a> fn(&RunView<'a>) -> &'a [f64], out: &mut Vec<Lane>| {
            interleave_into(&runs.iter().map(of).collect::<Vec<_>>(), out);
        };
        self.runs = runs.len();
        rows(|run| run.measured, &mut self.measured);
        rows(|run| run.exogenous, &mut self.exogenous);
        self.instrument_exogenous.clear();
        if runs.iter().any(RunView::has_instrument_inputs) {
            rows(|run| run.instrument_exogenous, &mut self.instrument_exogenous);
        }
        self.initial = [0, 1, 2].map(|d: usize| lane(runs.len(), |run| runs[run].initial[d]));
        self.samples = by_lane(runs.len(), |run| runs[run].samples());
    }
}
