//! Output error in memory: realizations of the paper's optimized experiment, started at instrumental variables.

use std::path::Path;

use identification::predictor::{Fit, InitialState, Recordings, Spread, output_error};
use identification::{Batch, MeanRemoval, Outcome, estimate};
use serde_json::{Value, json};
use vessel::{Current, Disturbances, LANES, Lane, Measurement, Source, Streams, simulate, simulate_one};

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
        "samples": realizations.samples,
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

/// The same inputs from the same initial state, measured [`RUNS`] times, [`LANES`] side by side.
struct Realizations<'a> {
    paper: &'a Paper,
    samples: usize,
    initial: [f64; 3],
    /// N × 3.
    inputs: Vec<f64>,
    /// The same in every lane.
    inputs_of_all: Vec<Lane>,
    groups: Vec<Group>,
}

struct Group {
    /// (N+1) × 3.
    measured: Vec<Lane>,
    /// Parameters that the fits start from.
    starts: [Vec<f64>; LANES],
}

impl<'a> Realizations<'a> {
    fn new(paper: &'a Paper) -> anyhow::Result<Self> {
        let mut inputs = Vec::new();
        for (maneuver, samples) in OPTIMIZED {
            inputs.extend(paper.generator.realize(maneuver, samples)?.inputs);
        }
        let mut own = Self {
            paper,
            samples: inputs.len() / 3,
            initial: paper.generator.realize(OPTIMIZED[0].0, 1)?.initial,
            inputs_of_all: inputs.iter().copied().map(Lane::splat).collect(),
            inputs,
            groups: Vec::new(),
        };
        let nominal = paper.vessel.parameters(Source::Nominal)?;
        let groups = (0..RUNS).step_by(LANES).map(|first| own.group(first, &nominal));
        own.groups = groups.collect();
        Ok(own)
    }

    /// Simulates and measures the runs from `first` on, and estimates by instrumental variables.
    fn group(&self, first: u32, nominal: &[f64]) -> Group {
        let model = &self.paper.vessel.model;
        let std = 0.025_f64.sqrt();
        let disturbances = Disturbances {
            current: Current::White { std_m_s: std },
            measurement: Measurement { std_u_m_s: std, std_v_m_s: std, std_r_rad_s: std },
        };
        let streams = Streams::new(1, "bench");
        let runs = std::array::from_fn(|lane| first + lane as u32);
        let current = disturbances.current(&streams, runs, self.samples, 8.0);
        let mut measured = vec![Lane::ZERO; 3 * (self.samples + 1)];
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
        let regressed = estimate(&batch, MeanRemoval::Complete);
        let start = |lane: usize| match &regressed[lane] {
            Outcome::Identified(found) => found.parameters.clone(),
            _ => nominal.to_vec(),
        };
        let starts = std::array::from_fn(start);
        Group { measured, starts }
    }

    fn fits(&self) -> Vec<Fit> {
        self.groups.iter().flat_map(|group| self.fit(group)).collect()
    }

    fn fit(&self, group: &Group) -> Vec<Fit> {
        let recordings = Recordings {
            model: &self.paper.vessel.model,
            measured: &group.measured,
            exogenous: &self.inputs_of_all,
            initial: self.initial.map(Lane::splat),
            samples: [self.samples; LANES],
        };
        let starts = std::slice::from_ref(&group.starts);
        output_error(&recordings, starts, InitialState::Known, Spread::Residuals)
    }

    fn told(&self, run: usize, fit: &Fit) -> Value {
        let (group, lane) = (&self.groups[run / LANES], run % LANES);
        let measured: Vec<f64> = group.measured.iter().map(|y| y[lane]).collect();
        let fitted = match fit {
            Fit::Converged(found) => {
                json!({"parameters": found.parameters, "standard_errors": found.standard_errors})
            }
            _ => Value::Null,
        };
        json!({"measured": measured, "start": group.starts[lane], "fitted": fitted})
    }
}
