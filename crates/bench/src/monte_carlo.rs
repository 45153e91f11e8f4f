//! Monte Carlo in memory: simulate, estimate, validate freely.

use identification::{Batch, FreeRun, Instruments, MeanRemoval, Outcome, free_runs, parameter_error};
use serde_json::{Value, json};
use vessel::{Current, Disturbances, LANES, Lane, Measurement, Source, Streams, simulate, simulate_one};

use crate::fastest;
use crate::paper::Paper;

/// Samples per maneuver of the optimized experiment: the paper study's design.
pub const OPTIMIZED: [(usize, usize); 6] = [(0, 193), (4, 43), (5, 229), (6, 101), (7, 85), (10, 349)];
const RUNS: u32 = 2000;

/// Realizations per second, and the shares below the paper's bounds.
pub fn measure(paper: &Paper) -> anyhow::Result<Value> {
    let study = Study::new(paper)?;
    let (seconds, (good_parameters, good_simulations)) = fastest(5, || study.run())?;
    Ok(json!({
        "realizations": RUNS,
        "realizations_per_s_per_core": f64::from(RUNS) / seconds,
        "parameter_error_share": good_parameters as f64 / f64::from(RUNS),
        "simulation_error_share": good_simulations as f64 / f64::from(RUNS),
    }))
}

struct Study<'a> {
    paper: &'a Paper,
    truth: Vec<f64>,
    nominal: Vec<f64>,
    inputs: Vec<f64>,
    initial: [f64; 3],
    segments: Vec<usize>,
    validation: Vec<f64>,
    reference: Vec<f64>,
    disturbances: Disturbances,
}

impl<'a> Study<'a> {
    fn new(paper: &'a Paper) -> anyhow::Result<Self> {
        let mut inputs = Vec::new();
        let mut segments = Vec::new();
        for (maneuver, samples) in OPTIMIZED {
            segments.push(inputs.len() / 3);
            inputs.extend(paper.generator.realize(maneuver, samples)?.inputs);
        }
        let initial = paper.generator.realize(OPTIMIZED[0].0, 1)?.initial;
        // A telegraph signal over the dictionary's inputs: something that no maneuver does.
        let levels = [paper.generator.realize(2, 300)?.inputs, paper.generator.realize(7, 300)?.inputs];
        let validation: Vec<f64> =
            (0..1000).flat_map(|k| levels[(k / 80) % 2][3 * (k % 300)..][..3].to_vec()).collect();
        let mut reference = vec![Lane::ZERO; 3 * 1001];
        let start = [0.6, 0.0, 0.0].map(Lane::splat);
        simulate(&paper.vessel.model, &paper.truth, start, &validation, &[], &mut reference);
        let std = 0.025_f64.sqrt();
        Ok(Self {
            paper,
            truth: paper.vessel.parameters(Source::Value)?,
            nominal: paper.vessel.parameters(Source::Nominal)?,
            inputs,
            initial,
            segments,
            validation,
            reference: reference.iter().map(|s| s[0]).collect(),
            disturbances: Disturbances {
                current: Current::White { std_m_s: std },
                measurement: Measurement { std_u_m_s: std, std_v_m_s: std, std_r_rad_s: std },
            },
        })
    }

    fn run(&self) -> anyhow::Result<(usize, usize)> {
        let model = &self.paper.vessel.model;
        let streams = Streams::new(1, "bench");
        let samples = self.inputs.len() / 3;
        let mut states = vec![Lane::ZERO; 3 * (samples + 1)];
        let nominal = simulate_one(model, &self.nominal, self.initial, &self.inputs);
        let mut instruments = None;
        let mut good = (0, 0);
        for first in (0..RUNS).step_by(LANES) {
            let runs = std::array::from_fn(|lane| first + lane as u32);
            let current = self.disturbances.current(&streams, runs, samples, 8.0);
            simulate(
                model,
                &self.paper.truth,
                self.initial.map(Lane::splat),
                &self.inputs,
                &current,
                &mut states,
            );
            self.disturbances.measure(&streams, runs, &mut states);
            let batch = Batch {
                model,
                measured: &states,
                instrument_states: &nominal,
                exogenous: &self.inputs,
                segments: [&self.segments; LANES],
            };
            let instruments =
                instruments.get_or_insert_with(|| Instruments::new(&batch, MeanRemoval::Complete));
            let outcomes = instruments.estimate(&batch);
            let mut lanes = vec![Lane::ZERO; model.parameters()];
            for (lane, outcome) in outcomes.iter().enumerate() {
                let Outcome::Identified(found) = outcome else { continue };
                lanes.iter_mut().zip(&found.parameters).for_each(|(l, p)| l[lane] = *p);
                let error = parameter_error(&found.parameters, &self.truth);
                good.0 += usize::from(error.is_some_and(|e| e < 5.0));
            }
            let errors = free_runs(model, &lanes, &self.validation, &self.reference);
            good.1 += errors.iter().filter(|e: &&FreeRun| e.norm().is_some_and(|n| n < 0.15)).count();
        }
        Ok(good)
    }
}
