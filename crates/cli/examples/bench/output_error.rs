//! Output error in memory: realizations of the paper's optimized experiment, started at instrumental variables.

use std::path::Path;

use estimation::predictor::{InitialState, RunFit, Spread, output_error};
use numerics::LANES;
use numerics::lanes::lane_of;
use regression::{Batch, Instruments, MeanRemoval, Outcome};
use serde_json::{Value, json};
use ship::engine::RunView;

use crate::paper::{Experiment, Paper};
use crate::timing::fastest;

const RUNS: u32 = 64;

/// Seconds per realization of 1000 samples, standard errors included, and how many converged.
pub fn measure(paper: &Paper) -> anyhow::Result<Value> {
    let realizations = Realizations::new(paper)?;
    let (seconds, fits) = fastest(5, || Ok(realizations.fits()))?;
    Ok(json!({
        "realizations": RUNS,
        "samples": realizations.experiment.samples(),
        "seconds_per_realization": seconds / f64::from(RUNS),
        "converged": fits.iter().filter(|fit| matches!(fit, RunFit::Converged(_))).count(),
    }))
}

/// Writes the realizations with their starts and estimates, for a peer to fit the same: one JSON object.
pub fn write(paper: &Paper, file: &Path) -> anyhow::Result<()> {
    let realizations = Realizations::new(paper)?;
    let fits = realizations.fits();
    let runs: Vec<Value> = (0..RUNS as usize).map(|run| realizations.told(run, &fits[run])).collect();
    let Experiment { initial, inputs, .. } = &realizations.experiment;
    let object = json!({"initial": initial, "inputs": inputs, "runs": runs});
    Ok(std::fs::write(file, object.to_string())?)
}

/// The optimized experiment, measured [`RUNS`] times.
struct Realizations<'a> {
    experiment: Experiment<'a>,
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
        let experiment = Experiment::new(paper)?;
        let runs = (0..RUNS).step_by(LANES).flat_map(|first| measured(&experiment, first)).collect();
        Ok(Self { experiment, runs })
    }

    fn fits(&self) -> Vec<RunFit> {
        let runs: Vec<RunView> = self.runs.iter().map(|run| self.recording(run)).collect();
        let model = self.experiment.paper.vessel.model.with_intercepts();
        let start = |run: &Measured| vec![model.layout().woven(&run.start, [0.0; 3])];
        let starts: Vec<Vec<Vec<f64>>> = self.runs.iter().map(start).collect();
        output_error(&model, &runs, &starts, InitialState::Known, Spread::Blocks)
    }

    fn recording<'b>(&'b self, run: &'b Measured) -> RunView<'b> {
        let Experiment { inputs, initial, .. } = &self.experiment;
        RunView {
            measured: &run.measured,
            instrument_exogenous: inputs,
            exogenous: inputs,
            initial: *initial,
        }
    }

    fn told(&self, run: usize, fit: &RunFit) -> Value {
        let Measured { measured, start } = &self.runs[run];
        let fitted = match fit {
            RunFit::Converged(found) => {
                json!({"parameters": found.parameters, "standard_errors": found.standard_errors})
            }
            _ => Value::Null,
        };
        json!({"measured": measured, "start": start, "fitted": fitted})
    }
}

/// [`LANES`] runs from number `first` on, with their estimates by instrumental variables.
fn measured(experiment: &Experiment, first: u32) -> Vec<Measured> {
    let vessel = &experiment.paper.vessel;
    let measured = experiment.measured(first);
    let batch = Batch {
        model: &vessel.model,
        measured: &measured,
        instrument_states: &experiment.nominal_states(),
        instrument_exogenous: &experiment.inputs,
        exogenous: &experiment.inputs,
        segments: [&[0]; LANES],
    };
    let one = |(lane, outcome): (usize, Outcome)| Measured {
        measured: lane_of(&measured, lane),
        start: match outcome {
            Outcome::Identified(found) => found.parameters,
            _ => vessel.nominal.clone(),
        },
    };
    let outcomes = Instruments::new(&batch, MeanRemoval::Complete).estimate(&batch);
    outcomes.into_iter().enumerate().map(one).collect()
}
