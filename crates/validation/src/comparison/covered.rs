use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use estimation::pooled::Covered;

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
        let found = |(covered, samples): (&Covered, &u64)| Outside {
            name: covered.name.clone(),
            unit: covered.unit.clone(),
            low: covered.low,
            high: covered.high,
            samples: *samples,
            share: *samples as f64 / self.samples.max(1) as f64,
        };
        let left = self.covered.iter().zip(&self.outside).filter(|(_, samples)| **samples > 0);
        left.map(found).collect()
    }
}
