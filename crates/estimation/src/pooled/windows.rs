use numerics::Lane;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use ship::engine::{RunView, check_diverged, replay};
use ship::model::Model;

use crate::{FreeRun, free_runs};

/// Squared errors of free simulations over several windows.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Score {
    /// Sum of squared errors in u, v, r over the windows that did not diverge.
    pub squares: [f64; 3],
    /// Their samples.
    pub samples: u64,
    /// Windows that diverged.
    pub diverged: u64,
}

impl Score {
    /// Simulates `model` with `parameters` over all `windows`.
    pub fn of<'a>(model: &Model, parameters: &[f64], windows: impl Iterator<Item = RunView<'a>>) -> Self {
        let lanes: Vec<Lane> = parameters.iter().copied().map(Lane::splat).collect();
        let mut score = Self::default();
        for window in windows {
            let [first, ..] = free_runs(model, &lanes, window.exogenous, window.measured);
            score.add(first, window.samples());
        }
        score
    }

    /// Adds a window of `samples` samples.
    pub fn add(&mut self, found: FreeRun, samples: usize) {
        match found {
            FreeRun::Rmse(rmse) => {
                let n = samples as f64;
                self.squares.iter_mut().zip(rmse).for_each(|(s, e)| *s += n * e * e);
                self.samples += samples as u64;
            }
            FreeRun::Diverged(_) => self.diverged += 1,
        }
    }

    /// Simulates `model` over all `windows`, one after the other, as [`replay`] does.
    pub fn replayed<'a>(
        model: &Model,
        parameters: &[f64],
        windows: impl Iterator<Item = RunView<'a>>,
        are_inputs_held: bool,
    ) -> Self {
        let mut score = Self::default();
        for window in windows {
            let states = replay(model, parameters, window.initial, window.exogenous, are_inputs_held);
            score.add_states(&states, window);
        }
        score
    }

    /// Adds a simulation of `window` from its first measured state: u, v, r row by row.
    pub fn add_states(&mut self, states: &[f64], window: RunView) {
        if check_diverged(states.iter().copied()).is_some() {
            self.diverged += 1;
            return;
        }
        self.samples += window.samples() as u64;
        for (i, (own, measured)) in states.iter().zip(window.measured).enumerate().skip(3) {
            self.squares[i % 3] += (own - measured).powi(2);
        }
    }

    /// Adds other windows.
    pub fn merge(&mut self, other: &Self) {
        self.squares.iter_mut().zip(other.squares).for_each(|(s, o)| *s += o);
        self.samples += other.samples;
        self.diverged += other.diverged;
    }

    /// RMSE in u, v \[m/s\], r \[rad/s\]; `None` if a window diverged or there is none.
    pub fn rmse(&self) -> Option<[f64; 3]> {
        let whole = self.diverged == 0 && self.samples > 0;
        whole.then(|| self.squares.map(|s| (s / self.samples as f64).sqrt()))
    }

    /// Errors against the standard deviations `std` of the measured states (see [`deviations`]); `None` as [`Score::rmse`].
    pub fn errors(&self, std: [f64; 3]) -> Option<FreeRunErrors> {
        let rmse = self.rmse()?;
        let fit = |d: usize| (std[d] > 0.0).then(|| 100.0 * (1.0 - rmse[d] / std[d]));
        let ([rmse_u, rmse_v, rmse_r], [fit_u, fit_v, fit_r]) = (rmse, [0, 1, 2].map(fit));
        Some(FreeRunErrors { rmse_u, rmse_v, rmse_r, fit_u, fit_v, fit_r })
    }

    /// The 2-norm of RMSE/std; `None` as [`Score::rmse`], and if a state does not vary.
    pub fn norm(&self, std: [f64; 3]) -> Option<f64> {
        let rmse = self.rmse()?;
        let norm = (0..3).map(|d| (rmse[d] / std[d]).powi(2)).sum::<f64>().sqrt();
        norm.is_finite().then_some(norm)
    }
}

/// Errors of free simulations. Fit: 100 (1 − RMSE/std), 0 as good as the mean of the data.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FreeRunErrors {
    /// Of surge speed.
    pub rmse_u: f64,
    /// Of sway speed.
    pub rmse_v: f64,
    /// Of yaw rate.
    pub rmse_r: f64,
    /// Of surge speed; null where it does not vary.
    pub fit_u: Option<f64>,
    /// Of sway speed.
    pub fit_v: Option<f64>,
    /// Of yaw rate.
    pub fit_r: Option<f64>,
}

impl FreeRunErrors {
    /// Fits of u, v, r.
    pub fn fits(&self) -> [Option<f64>; 3] {
        [self.fit_u, self.fit_v, self.fit_r]
    }
}

/// Standard deviations of u, v, r over samples 1 to N of several (N+1) × 3 states, as of a whole population.
pub fn deviations<'a>(measured: impl Iterator<Item = &'a [f64]> + Clone) -> [f64; 3] {
    let mut means = StateMeans::default();
    measured.clone().for_each(|states| means.add(states));
    let mut deviations = means.deviations();
    measured.for_each(|states| deviations.add(states));
    deviations.found()
}

/// Σ u, Σ v, Σ r over samples 1 to N of several (N+1) × 3 states.
#[derive(Clone, Copy, Debug)]
pub(super) struct StateMeans {
    rows: usize,
    sums: [f64; 3],
}

/// Sums of squares about those means.
#[derive(Clone, Copy, Debug)]
pub(super) struct StateDeviations {
    rows: usize,
    means: [f64; 3],
    squares: [f64; 3],
}

impl Default for StateMeans {
    fn default() -> Self {
        // The start value of `Iterator::sum`, so that sums part by part have the same bits.
        Self { rows: 0, sums: [std::iter::empty::<f64>().sum(); 3] }
    }
}

impl StateMeans {
    pub(super) fn add(&mut self, states: &[f64]) {
        for row in states.chunks_exact(3).skip(1) {
            self.rows += 1;
            (0..3).for_each(|d| self.sums[d] += row[d]);
        }
    }

    /// Starts a second pass over the same states.
    pub(super) fn deviations(&self) -> StateDeviations {
        let means = self.sums.map(|sum| sum / self.rows as f64);
        StateDeviations { rows: self.rows, means, squares: Self::default().sums }
    }
}

impl StateDeviations {
    pub(super) fn add(&mut self, states: &[f64]) {
        for row in states.chunks_exact(3).skip(1) {
            (0..3).for_each(|d| self.squares[d] += (row[d] - self.means[d]) * (row[d] - self.means[d]));
        }
    }

    pub(super) fn found(&self) -> [f64; 3] {
        let n = self.rows as f64;
        let of = |squares: f64| (squares / (n - 1.0)).sqrt() * ((n - 1.0) / n).sqrt();
        if self.rows > 1 { self.squares.map(of) } else { [0.0; 3] }
    }
}
