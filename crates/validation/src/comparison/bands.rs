use identification::pooled::Covariance;
use identification::predictor::{Recordings, Sensitivities};
use model::Model;
use numerics::statistics::Z;
use numerics::times;
use regression::pooled::Part;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The estimated errors of the model.
#[derive(Clone, Copy, Debug)]
pub struct Known<'a> {
    /// Of its parameters; `None` for an average, whose spread is used instead, and if no covariance is valid.
    pub covariance: Option<&'a Covariance>,
    /// RMSE of u, v, r on the recordings that it was fitted to, or, without a covariance, on those that were left
    /// out.
    pub rmse: [f64; 3],
}

/// Shares of the measured samples inside the 95 % bands of a model: from its parameters' covariance, or how far the models of an
/// average are apart, and the errors that its simulations had on what it was fitted to. Of a searched model: from its errors
/// on what was left out of the search.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Bands {
    /// Of u.
    pub inside_u: f64,
    /// Of v.
    pub inside_v: f64,
    /// Of r.
    pub inside_r: f64,
}

impl Bands {
    pub(super) fn of([inside_u, inside_v, inside_r]: [f64; 3]) -> Self {
        Self { inside_u, inside_v, inside_r }
    }
}

/// Counts of measured samples inside bands.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Inside {
    inside: [u64; 3],
    samples: u64,
}

impl Inside {
    /// Adds a window with its simulated `states`; `half` is the half-width of the bands. The first sample, where the
    /// simulation starts, is not counted.
    pub fn add(&mut self, window: &Part, states: &[f64], half: &[[f64; 3]]) {
        let pairs = window.measured.as_chunks::<3>().0.iter().zip(states.as_chunks::<3>().0);
        for ((measured, simulated), half) in pairs.zip(half).skip(1) {
            self.samples += 1;
            for d in 0..3 {
                self.inside[d] += u64::from((measured[d] - simulated[d]).abs() <= half[d]);
            }
        }
    }

    pub fn samples(&self) -> u64 {
        self.samples
    }

    /// The shares inside; `None` without samples.
    pub fn shares(&self) -> Option<[f64; 3]> {
        (self.samples > 0).then(|| self.inside.map(|n| n as f64 / self.samples as f64))
    }
}

/// The bands of one model.
pub(super) struct Banded<'a> {
    model: Model,
    unknowns: Vec<f64>,
    free: Vec<usize>,
    covariance: Option<&'a Covariance>,
    rmse: [f64; 3],
    inside: Inside,
}

impl<'a> Banded<'a> {
    /// The bands of `model` with parameters `theta`.
    pub fn new(model: &Model, theta: &[f64], Known { covariance, rmse }: Known<'a>) -> Self {
        let lifted = model.with_intercepts();
        let layout = lifted.layout();
        // The model contains the constant; its error is that of an intercept of zero.
        let unknowns = [layout.woven(theta, [0.0; 3]), vec![0.0; 3]].concat();
        let joint = covariance.is_some_and(|own| own.names.len() == layout.parameters());
        let counts = layout.are_intercepts().map(|intercept| joint || !intercept);
        let free = counts.enumerate().filter_map(|(i, counts)| counts.then_some(i)).collect();
        Self { model: lifted, unknowns, free, covariance, rmse, inside: Inside::default() }
    }

    /// Half-widths of the bands over `window` with its simulated `states`, (N+1) × 3; counts the samples inside.
    pub fn add(&mut self, window: &Part, states: &[f64]) -> Vec<[f64; 3]> {
        let Some(covariance) = self.covariance else {
            let bands = vec![self.rmse.map(|rmse| Z * rmse); window.samples() + 1];
            self.inside.add(window, states, &bands);
            return bands;
        };
        let recordings = Recordings {
            measured: &window.measured,
            ..Recordings::simulated(&self.model, window.view().initial, &window.exogenous)
        };
        let found = Sensitivities::of(&recordings, &self.unknowns, &self.free, true);
        let half = |k: usize| self.half(covariance, &found, k);
        let bands: Vec<[f64; 3]> = (0..=window.samples()).map(half).collect();
        self.inside.add(window, states, &bands);
        bands
    }

    fn half(&self, covariance: &Covariance, found: &Sensitivities<f64>, k: usize) -> [f64; 3] {
        let all: Vec<[f64; 3]> = (0..self.free.len()).map(|i| found.by(k, i)).collect();
        [0, 1, 2].map(|d| {
            let by: Vec<f64> = all.iter().map(|by| by[d]).collect();
            let moved = times(&covariance.entries, &by);
            let variance: f64 = by.iter().zip(moved).map(|(a, b)| a * b).sum();
            Z * (variance.max(0.0) + self.rmse[d].powi(2)).sqrt()
        })
    }

    /// The shares inside; `None` without samples.
    pub fn shares(&self) -> Option<Bands> {
        self.inside.shares().map(Bands::of)
    }
}
