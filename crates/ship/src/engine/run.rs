use numerics::lanes::{by_lane, interleave_into, lane};
use numerics::{LANES, Lane};

/// One run, as recorded.
#[derive(Clone, Debug, PartialEq)]
pub struct Run {
    /// Its design.
    pub design: String,
    /// Its number.
    pub run: i32,
    /// Its segments, in order.
    pub segments: Vec<Segment>,
    /// Inputs and measured disturbances, N × exogenous, row-major.
    pub exogenous: Vec<f64>,
    /// Those that instruments are simulated with, N × exogenous; empty where they are the recorded ones.
    pub instrument_exogenous: Vec<f64>,
    /// Measured states, (N+1) × 3, row-major.
    pub measured: Vec<f64>,
    /// State that simulations of the run start from: the true one if the file has it, else the measured one.
    pub initial: [f64; 3],
}

/// One maneuver inside a run.
#[derive(Clone, Debug, PartialEq)]
pub struct Segment {
    /// Name of the maneuver.
    pub maneuver: String,
    /// First sample.
    pub start: usize,
}

/// A recorded run, or a part of one: N samples, row-major.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RunView<'a> {
    /// Measured states u, v \[m/s\], r \[rad/s\]: (N+1) × 3.
    pub measured: &'a [f64],
    /// Inputs and measured disturbances: N × exogenous.
    pub exogenous: &'a [f64],
    /// Those that instruments are simulated with: N × exogenous. The recorded ones follow the noise of the measured states,
    /// where a controller reads the logged sensors; those of a nominal ship under the same controller do not.
    pub instrument_exogenous: &'a [f64],
    /// State that simulations start from.
    pub initial: [f64; 3],
}

impl<'a> RunView<'a> {
    /// A measured run, whose simulations start from its first state.
    pub fn measured(measured: &'a [f64], exogenous: &'a [f64]) -> Self {
        Self { measured, exogenous, instrument_exogenous: exogenous, initial: [0, 1, 2].map(|d| measured[d]) }
    }

    /// Whether instruments are simulated with other inputs than the recorded ones.
    pub fn has_instrument_inputs(&self) -> bool {
        !std::ptr::eq(self.exogenous, self.instrument_exogenous)
    }

    /// A copy of the inputs that instruments are simulated with; empty where they are the recorded ones.
    pub fn own_instrument_inputs(&self) -> Vec<f64> {
        if self.has_instrument_inputs() { self.instrument_exogenous.to_vec() } else { Vec::new() }
    }

    /// Number of samples N.
    pub fn samples(&self) -> usize {
        self.measured.len() / 3 - 1
    }

    /// A part of `samples`; simulations start from the first measured state there.
    pub fn part(&self, samples: std::ops::Range<usize>) -> Self {
        let width = self.exogenous.len() / self.samples().max(1);
        let rows = samples.start * width..samples.end * width;
        let measured = &self.measured[3 * samples.start..3 * (samples.end + 1)];
        let instrument_exogenous = &self.instrument_exogenous[rows.clone()];
        Self { instrument_exogenous, ..Self::measured(measured, &self.exogenous[rows]) }
    }
}

impl Run {
    /// The whole run.
    pub fn view(&self) -> RunView<'_> {
        let Self { measured, exogenous, instrument_exogenous, initial, .. } = self;
        let instrument_exogenous =
            if instrument_exogenous.is_empty() { exogenous } else { instrument_exogenous };
        RunView { measured, exogenous, instrument_exogenous, initial: *initial }
    }

    /// Number of regression pairs N.
    pub fn samples(&self) -> usize {
        self.measured.len() / 3 - 1
    }

    /// First samples of the segments.
    pub fn starts(&self) -> Vec<usize> {
        self.segments.iter().map(|s| s.start).collect()
    }
}

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
