//! Monte Carlo in memory: simulate, estimate, validate freely.

use estimation::{FreeRun, free_runs, parameter_error};
use numerics::{LANES, Lane};
use regression::{Batch, Instruments, MeanRemoval, Outcome};
use serde_json::{Value, json};
use ship::engine::simulate_one;
use ship::model::Source;

use crate::paper::{Experiment, Paper};
use crate::timing::fastest;

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
    experiment: Experiment<'a>,
    truth: Vec<f64>,
    validation: Vec<f64>,
    reference: Vec<f64>,
}

impl<'a> Study<'a> {
    fn new(paper: &'a Paper) -> anyhow::Result<Self> {
        // A telegraph signal over the dictionary's inputs: something that no maneuver does.
        let levels = [paper.generator.realize(2, 300)?.inputs, paper.generator.realize(7, 300)?.inputs];
        let validation: Vec<f64> =
            (0..1000).flat_map(|k| levels[(k / 80) % 2][3 * (k % 300)..][..3].to_vec()).collect();
        let truth = paper.vessel.parameters(Source::Value)?;
        let reference = simulate_one(&paper.vessel.model, &truth, [0.6, 0.0, 0.0], &validation);
        Ok(Self { experiment: Experiment::new(paper)?, truth, validation, reference })
    }

    fn run(&self) -> anyhow::Result<(usize, usize)> {
        let Experiment { paper, inputs, segments, .. } = &self.experiment;
        let model = &paper.vessel.model;
        let nominal = self.experiment.nominal_states();
        let mut instruments = None;
        let mut good = (0, 0);
        for first in (0..RUNS).step_by(LANES) {
            let batch = Batch {
                model,
                measured: &self.experiment.measured(first),
                instrument_states: &nominal,
                instrument_exogenous: inputs,
                exogenous: inputs,
                segments: [segments; LANES],
            };
            let instruments =
                instruments.get_or_insert_with(|| Instruments::new(&batch, MeanRemoval::Complete));
            let outcomes = instruments.parameters(&batch);
            let mut lanes = vec![Lane::ZERO; model.parameters()];
            for (lane, outcome) in outcomes.iter().enumerate() {
                let Outcome::Identified(found) = outcome else { continue };
                lanes.iter_mut().zip(found).for_each(|(l, p)| l[lane] = *p);
                let error = parameter_error(found, &self.truth);
                good.0 += usize::from(error < 5.0);
            }
            let errors = free_runs(model, &lanes, &self.validation, &self.reference);
            good.1 += errors.iter().filter(|e: &&FreeRun| e.norm().is_some_and(|n| n < 0.15)).count();
        }
        Ok(good)
    }
}
