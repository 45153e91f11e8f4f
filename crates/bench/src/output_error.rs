//! Output error in memory: realizations of the paper's optimized experiment, started at instrumental variables.

use std::path::Path;

use identification::predictor::{Fit, InitialState, Spread, output_error};
use identification::{Batch, Instruments, MeanRemoval, Outcome};
use serde_json::{Value, json};
use vessel::{
    Current, Disturbances, LANES, Lane, Measurement, RunView, Source, Streams, simulate, simulate_one,
};

use crate::fastest;
use crate::monte_carlo::OPTIMIZED;
use crate::paper::Paper;

const RUNS: u32 = 64;

/// Seconds per realization of 1000 samples, standard errors included, and how many converged.
pub fn measure(paper: &Paper) -> anyhow::Result<Value> {
    let realizations = Realizations::new(paper)?;
    let (seconds, fits) = fastest(5, || Ok(realizations.fits()))?;
    Ok(json!({
        "realizations": RUNS,
        "samples": realizations.inputs.len() / 3,
        "seconds_per_realization": seconds / f64::from(RUNS),
        "converged": fits.iter().filter(|fit| matches!(fit, Fit::Converged(_))).count(),
    }))
}

/// Writes the realizations with their starts and estimates, for a peer to fit the same: one JSON object.
pub fn write(paper: &Paper, file: &Path) -> anyhow::Result<()> {
    let realizations = Realizations::new(paper)?;
    let fits = realizations.fits();
    let runs: Vec<Value> = (0..RUNS as usize).map(|run| realizations.told(run, &fits[run])).collect();
    let object = json!({"initial": realizations.initial, "inputs": realizations.inputs, "runs": runs});
    Ok(std::fs::write(file, object.to_string())?)
}

/// The same inputs from the same initial state, measured [`RUNS`] times.
struct Realizations<'a> {
    paper: &'a Paper,
    initial: [f64; 3],
    /// N × 3.
    inputs: Vec<f64>,
    runs: Vec<Measured>,
}

struct Measured {
    /// (N+1) × 3.
    measured: Vec<f64>,
    /// Parameters that the fit starts from.
    start: Vec<f64>,
}

impl<'a> Realizations<'a> {
    fn new(paper: &'a Paper) -> anyhow::Result<Self> {
        let mut inputs = Vec::new();
        for (maneuver, samples) in OPTIMIZED {
            inputs.extend(paper.generator.realize(maneuver, samples)?.inputs);
        }
        let initial = paper.generator.realize(OPTIMIZED[0].0, 1)?.initial;
        let mut own = Self { paper, initial, inputs, runs: Vec::new() };
        let nominal = paper.vessel.parameters(Source::Nominal)?;
        own.runs = (0..RUNS).step_by(LANES).flat_map(|first| own.measured(first, &nominal)).collect();
        Ok(own)
    }

    /// Simulates and measures [`LANES`] runs from `first` on, and estimates by instrumental variables.
    fn measured(&self, first: u32, nominal: &[f64]) -> Vec<Measured> {
        let (model, samples) = (&self.paper.vessel.model, self.inputs.len() / 3);
        let std = 0.025_f64.sqrt();
        let disturbances = Disturbances {
            current: Current::White { std_m_s: std },
            measurement: Measurement { std_u_m_s: std, std_v_m_s: std, std_r_rad_s: std },
        };
        let streams = Streams::new(1, "bench");
        let runs = std::array::from_fn(|lane| first + lane as u32);
        let current = disturbances.current(&streams, runs, samples, 8.0);
        let mut measured = vec![Lane::ZERO; 3 * (samples + 1)];
        let initial = self.initial.map(Lane::splat);
        simulate(model, &self.paper.truth, initial, &self.inputs, &current, &mut measured);
        disturbances.measure(&streams, runs, &mut measured);
        let batch = Batch {
            model,
            measured: &measured,
            instrument_states: &simulate_one(model, nominal, self.initial, &self.inputs),
            exogenous: &self.inputs,
            segments: [&[0]; LANES],
        };
        let one = |(lane, outcome): (usize, Outcome)| Measured {
            measured: measured.iter().map(|y| y[lane]).collect(),
            start: match outcome {
                Outcome::Identified(found) => found.parameters,
                _ => nominal.to_vec(),
            },
        };
        let outcomes = Instruments::new(&batch, MeanRemoval::Complete).estimate(&batch);
        outcomes.into_iter().enumerate().map(one).collect()
    }

    fn fits(&self) -> Vec<Fit> {
        let runs: Vec<RunView> = self.runs.iter().map(|run| self.recording(run)).collect();
        let model = self.paper.vessel.model.with_intercepts();
        let start = |run: &Measured| vec![model.layout().woven(&run.start, [0.0; 3])];
        let starts: Vec<Vec<Vec<f64>>> = self.runs.iter().map(start).collect();
        output_error(&model, &runs, &starts, InitialState::Known, Spread::Residuals)
    }

    fn recording<'b>(&'b self, run: &'b Measured) -> RunView<'b> {
        RunView { measured: &run.measured, exogenous: &self.inputs, initial: self.initial }
    }

    fn told(&self, run: usize, fit: &Fit) -> Value {
        let Measured { measured, start } = &self.runs[run];
        let fitted = match fit {
            Fit::Converged(found) => {
                json!({"parameters": found.parameters, "standard_errors": found.standard_errors})
            }
            _ => Value::Null,
        };
        json!({"measured": measured, "start": start, "fitted": fitted})
    }
}
