//! Output error in memory: realizations of the paper's optimized experiment, started at instrumental variables.

use identification::predictor::{Fit, InitialState, Recording, Spread, output_error};
use identification::{Batch, MeanRemoval, Outcome, estimate};
use serde_json::{Value, json};
use vessel::{Current, Disturbances, LANES, Lane, Measurement, Source, Streams, simulate, simulate_one};

use crate::fastest;
use crate::monte_carlo::OPTIMIZED;
use crate::paper::Paper;

const RUNS: u32 = 64;

/// Seconds per realization of 1000 samples, with standard errors, and how many converged.
pub fn measure(paper: &Paper) -> anyhow::Result<Value> {
    let (seconds, converged) = fastest(3, || run(paper))?;
    Ok(json!({
        "realizations": RUNS,
        "seconds_per_realization": seconds / f64::from(RUNS),
        "converged": converged,
    }))
}

fn run(paper: &Paper) -> anyhow::Result<usize> {
    let model = &paper.vessel.model;
    let mut inputs = Vec::new();
    for (maneuver, samples) in OPTIMIZED {
        inputs.extend(paper.generator.realize(maneuver, samples)?.inputs);
    }
    let initial = paper.generator.realize(OPTIMIZED[0].0, 1)?.initial;
    let samples = inputs.len() / 3;
    let nominal = paper.vessel.parameters(Source::Nominal)?;
    let instrument_states = simulate_one(model, &nominal, initial, &inputs);
    let std = 0.025_f64.sqrt();
    let disturbances = Disturbances {
        current: Current::White { std_m_s: std },
        measurement: Measurement { std_u_m_s: std, std_v_m_s: std, std_r_rad_s: std },
    };
    let streams = Streams::new(1, "bench");
    let mut measured = vec![Lane::ZERO; 3 * (samples + 1)];
    let mut converged = 0;
    for first in (0..RUNS).step_by(LANES) {
        let runs = std::array::from_fn(|lane| first + lane as u32);
        let current = disturbances.current(&streams, runs, samples, 8.0);
        simulate(model, &paper.truth, initial.map(Lane::splat), &inputs, &current, &mut measured);
        disturbances.measure(&streams, runs, &mut measured);
        let batch = Batch {
            model,
            measured: &measured,
            instrument_states: &instrument_states,
            exogenous: &inputs,
            segments: [&[0]; LANES],
        };
        let regressed = estimate(&batch, MeanRemoval::Complete);
        let start = |found: &Outcome| match found {
            Outcome::Identified(found) => vec![found.parameters.clone()],
            _ => vec![nominal.clone()],
        };
        let starts: Vec<Vec<Vec<f64>>> = regressed.iter().map(start).collect();
        let rows: Vec<Vec<f64>> = (0..LANES).map(|lane| measured.iter().map(|y| y[lane]).collect()).collect();
        let recording = |measured| Recording { measured, exogenous: &inputs, initial };
        let recordings: Vec<Recording> = rows.iter().map(|row| recording(row)).collect();
        let fits = output_error(model, &recordings, &starts, InitialState::Known, Spread::Residuals);
        converged += fits.iter().filter(|fit| matches!(fit, Fit::Converged(_))).count();
    }
    Ok(converged)
}
