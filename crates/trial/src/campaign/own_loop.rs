use std::ops::Range;

use ship::engine::{Helm, simulate_command};
use ship::model::{Model, Vessel};

/// The inputs of the nominal ship under the controllers of an experiment, in still water: the instruments of tracked motions. There
/// recorded inputs follow all that the controller saw.
#[derive(Clone, Debug, PartialEq)]
pub struct OwnLoop {
    /// N × exogenous, row-major.
    exogenous: Vec<f64>,
    /// The samples at which motions are tracked. Inputs that change when a heading is reached are instruments as they are: the
    /// nominal ship would reach it at another time.
    tracked: Vec<Range<usize>>,
}

impl OwnLoop {
    /// Of `parts`, each for so many samples, from `initial`; `None` where none of them tracks a motion.
    pub fn new(vessel: &Vessel, initial: [f64; 3], parts: &[(Helm, usize)]) -> Option<Self> {
        let mut end = 0;
        let mut range = |(helm, samples): &(Helm, usize)| {
            end += samples;
            helm.tracks().then_some(end - samples..end)
        };
        let tracked: Vec<Range<usize>> = parts.iter().filter_map(&mut range).collect();
        if tracked.is_empty() {
            return None;
        }
        let (model, rate_hz) = (&vessel.model, vessel.sample_rate_hz);
        let helm = Helm::sequence(parts.to_vec());
        let run = simulate_command(model, &vessel.nominal, initial, end, rate_hz, &helm);
        Some(Self { exogenous: run.exogenous, tracked })
    }

    /// What instruments are simulated with in a run with these `recorded` inputs and measured disturbances, N × exogenous.
    pub fn instruments(&self, model: &Model, recorded: &[f64]) -> Vec<f64> {
        let (width, inputs) = (model.exogenous(), model.inputs);
        let mut rows = recorded.to_vec();
        for k in self.tracked.iter().cloned().flatten() {
            let row = &mut rows[width * k..width * (k + 1)];
            row[..inputs].copy_from_slice(&self.exogenous[width * k..][..inputs]);
            model.complete(row);
        }
        rows
    }
}
