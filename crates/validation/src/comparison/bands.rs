use estimation::pooled::{Covariance, Covered};
use estimation::state_slopes;
use numerics::statistics::Z;
use numerics::times;
use regression::pooled::Part;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use ship::engine::RunView;

use super::simulated::Ship;

/// The estimated errors of the model.
#[derive(Clone, Copy, Debug)]
pub struct EstimatedErrors<'a> {
    /// Of its parameters; `None` for an average, whose spread is used instead, and if no covariance is valid. That of
    /// forces has all of them.
    pub covariance: Option<&'a Covariance>,
    /// RMSE of u, v, r on the recordings that it was fitted to, or, without a covariance, on those that were left out.
    pub rmse: [f64; 3],
}

/// Shares of the measured samples inside the 95 % bands of a model: from its parameters' covariance, or how far the models of an
/// average are apart, and the errors that its simulations had on what it was fitted to. Of a searched model: from its errors
/// on what was left out of the search. Of an average of models that have bands of their own: the mean of these, which is wide
/// enough however the models' errors correlate.
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

    /// The shares inside; `None` without samples.
    pub fn shares(&self) -> Option<[f64; 3]> {
        (self.samples > 0).then(|| self.inside.map(|n| n as f64 / self.samples as f64))
    }
}

/// The bands of one model.
pub(super) struct Banded<'a> {
    ship: Ship<'a>,
    known: EstimatedErrors<'a>,
}

impl<'a> Banded<'a> {
    /// The bands of `ship`.
    pub fn new(ship: Ship<'a>, known: EstimatedErrors<'a>) -> Self {
        Self { ship, known }
    }

    /// Half-widths of the bands over `window`; `None` where its derivatives by the parameters are not finite.
    pub fn halves(&self, window: &Part, are_inputs_held: bool) -> Option<Vec<[f64; 3]>> {
        let Some(covariance) = self.known.covariance else {
            return Some(vec![self.known.rmse.map(|rmse| Z * rmse); window.samples() + 1]);
        };
        let exogenous = self.ship.exogenous(window);
        let run = RunView::measured(&window.measured, &exogenous);
        let (model, theta) = (self.ship.model, self.ship.theta);
        let slopes = state_slopes(model, theta, covariance.names.len(), &run, are_inputs_held)?;
        Some(slopes.iter().map(|by| self.half(covariance, by)).collect())
    }

    /// From the derivatives of u, v and r by the parameters of `covariance`.
    fn half(&self, covariance: &Covariance, by: &[Vec<f64>; 3]) -> [f64; 3] {
        let wider = (covariance.half_width() / Z).powi(2);
        [0, 1, 2].map(|d: usize| {
            let moved = times(&covariance.entries, &by[d]);
            let variance: f64 = by[d].iter().zip(moved).map(|(a, b)| a * b).sum();
            Z * (wider * variance.max(0.0) + self.known.rmse[d].powi(2)).sqrt()
        })
    }
}

/// How far the models of an average are apart.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Spread {
    /// Their number.
    pub models: u64,
    /// Root mean square over all samples of their standard deviation in u.
    pub spread_u: f64,
    /// In v.
    pub spread_v: f64,
    /// In r.
    pub spread_r: f64,
    /// Shares of the measured samples within 1.96 of these standard deviations of the average, sample by sample: small where
    /// models agree on what they all get wrong.
    pub inside_u: f64,
    /// Of v.
    pub inside_v: f64,
    /// Of r.
    pub inside_r: f64,
}

impl Spread {
    /// In words.
    pub fn statement(&self) -> String {
        let Self { models, spread_u, spread_v, spread_r, inside_u, inside_v, inside_r } = self;
        let [u, v, r] = [inside_u, inside_v, inside_r].map(|share| 100.0 * share);
        format!(
            "{models} models are averaged, which differ by a standard deviation of {spread_u:.3e} m/s in u, {spread_v:.3e} m/s in \
             v, {spread_r:.3e} rad/s in r; inside 1.96 of it alone: u {u:.1} %, v {v:.1} %, r {r:.1} % of the samples"
        )
    }
}

/// The bands of an average: from the spread of its models, and its errors on the recordings that they were fitted to.
pub(super) struct Spreads {
    models: usize,
    rmse: Option<[f64; 3]>,
    squares: [f64; 3],
    alone: Inside,
    pub together: Inside,
}

impl Spreads {
    /// The spreads of this number of `models`, whose average had errors of `rmse`.
    pub fn new(models: usize, rmse: Option<[f64; 3]>) -> Self {
        Self { models, rmse, squares: [0.0; 3], alone: Inside::default(), together: Inside::default() }
    }

    /// Half-widths of the bands over `window`, where `states` are the average and `spread` the models' standard
    /// deviations; `None` if the errors are not known.
    pub fn add(&mut self, window: &Part, states: &[f64], spread: &[f64]) -> Option<Vec<[f64; 3]>> {
        let rows = spread.as_chunks::<3>().0;
        for row in rows.iter().skip(1) {
            (0..3).for_each(|d| self.squares[d] += row[d] * row[d]);
        }
        let alone: Vec<[f64; 3]> = rows.iter().map(|row| row.map(|std| Z * std)).collect();
        self.alone.add(window, states, &alone);
        let rmse = self.rmse?;
        let with = |row: &[f64; 3]| [0, 1, 2].map(|d| Z * (row[d] * row[d] + rmse[d] * rmse[d]).sqrt());
        let bands: Vec<[f64; 3]> = rows.iter().map(with).collect();
        self.together.add(window, states, &bands);
        Some(bands)
    }

    /// The spread over all windows; `None` without samples.
    pub fn spread(&self) -> Option<Spread> {
        let [inside_u, inside_v, inside_r] = self.alone.shares()?;
        let [spread_u, spread_v, spread_r] = self.squares.map(|sum| (sum / self.alone.samples as f64).sqrt());
        let models = self.models as u64;
        Some(Spread { models, spread_u, spread_v, spread_r, inside_u, inside_v, inside_r })
    }
}

/// How often a channel leaves the range that the model was fitted on.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Outside {
    /// The channel: a state as simulated, an input or measured disturbance as logged.
    pub name: String,
    /// Its unit.
    pub unit: String,
    /// Least value that the model was fitted on.
    pub low: f64,
    /// Largest.
    pub high: f64,
    /// Samples outside.
    pub samples: u64,
    /// Their share.
    pub share: f64,
}

impl Outside {
    /// In words.
    pub fn statement(&self) -> String {
        let Self { name, unit, low, high, share, samples } = self;
        format!(
            "{name} leaves the {low:.4} to {high:.4} {unit} that the model was fitted on in {samples} samples ({:.1} %)",
            100.0 * share
        )
    }
}

/// Counts samples outside `covered`, which lists states, inputs, measured disturbances in the model's order.
pub struct Counter<'a> {
    covered: &'a [Covered],
    outside: Vec<u64>,
    samples: u64,
}

impl<'a> Counter<'a> {
    /// A counter without samples.
    pub fn new(covered: &'a [Covered]) -> Self {
        Self { covered, outside: vec![0; covered.len()], samples: 0 }
    }

    /// Adds the samples of a run: inputs and measured disturbances, and the `states`, (N+1) × 3.
    pub fn add(&mut self, exogenous: &[f64], states: &[f64]) {
        let width = self.covered.len().saturating_sub(3);
        let inputs = exogenous.chunks_exact(width.max(1));
        for (state, inputs) in states.as_chunks::<3>().0.iter().zip(inputs) {
            self.samples += 1;
            for (i, value) in state.iter().chain(inputs).enumerate().take(self.covered.len()) {
                self.outside[i] += u64::from(!self.covered[i].contains(*value));
            }
        }
    }

    /// The channels with samples outside.
    pub fn outside(&self) -> Vec<Outside> {
        let outside_of = |(covered, samples): (&Covered, &u64)| {
            let (Covered { name, unit, low, high }, samples) = (covered.clone(), *samples);
            let share = samples as f64 / self.samples.max(1) as f64;
            Outside { name, unit, low, high, samples, share }
        };
        let left = self.covered.iter().zip(&self.outside).filter(|(_, samples)| **samples > 0);
        left.map(outside_of).collect()
    }
}
