//! Runs of the paper's vessel, in lanes as the crate takes them. No test file uses all of it.

#![allow(dead_code)]

pub mod craft;
pub mod explicit;
pub mod noise;

use maneuver::{DictionaryFile, Generator};
use noise::Normals;
use numerics::{LANES, Lane, Number};
use regression::{Batch, Instruments, MeanRemoval, Outcome};
use ship::engine::simulate_one;
use ship::model::{Model, Source, Vessel};

const VESSEL: &str = include_str!("../../../../../pipelines/paper/vessel.toml");
const DICTIONARY: &str = include_str!("../../../../../pipelines/scenarios/dictionary.toml");

/// The vessel of the paper's simulation study.
pub fn paper() -> Vessel {
    Vessel::from_file(VESSEL.parse().unwrap()).unwrap()
}

/// Every run of `batch` estimated.
pub fn estimate<X: Number>(batch: &Batch<X>, removal: MeanRemoval) -> Vec<Outcome> {
    Instruments::new(batch, removal).estimate(batch)
}

/// Its eleven maneuvers.
pub fn dictionary(vessel: &Vessel) -> Generator {
    let file: DictionaryFile = DICTIONARY.parse().unwrap();
    Generator::without_tables(vessel, &file).unwrap()
}

pub fn truth(vessel: &Vessel) -> Vec<f64> {
    vessel.parameters(Source::Value).unwrap()
}

/// Initial state, inputs N × 3, first sample of each segment.
pub struct Experiment {
    pub initial: [f64; 3],
    pub inputs: Vec<f64>,
    pub segments: Vec<usize>,
}

impl Experiment {
    /// Maneuvers one after the other, each (index in the dictionary, samples); the state carries over.
    pub fn of_maneuvers(generator: &Generator, plan: &[(usize, usize)]) -> Self {
        let first = generator.realize(plan[0].0, plan[0].1).unwrap();
        let mut experiment = Self { initial: first.initial, inputs: Vec::new(), segments: Vec::new() };
        for (index, samples) in plan {
            experiment.segments.push(experiment.inputs.len() / 3);
            experiment.inputs.extend(generator.realize(*index, *samples).unwrap().inputs);
        }
        experiment
    }

    /// Inputs that jump to random levels every ten samples, in segments of the given lengths.
    pub fn random(normals: &mut Normals, lengths: &[usize]) -> Self {
        let mut experiment = Self { initial: [0.6, 0.0, 0.0], inputs: Vec::new(), segments: Vec::new() };
        let mut level = [0.0; 3];
        for length in lengths {
            let start = experiment.inputs.len() / 3;
            experiment.segments.push(start);
            let offset = normals.next();
            for k in start..start + length {
                if k % 10 == 0 || k == start {
                    level =
                        [3500.0 + 1500.0 * normals.next(), 400.0 * normals.next(), 200.0 * normals.next()];
                    level[2] += 100.0 * offset;
                }
                experiment.inputs.extend(level);
            }
        }
        experiment
    }

    /// States of the true or the nominal model in still water, (N+1) × 3.
    pub fn states(&self, vessel: &Vessel, source: Source) -> Vec<f64> {
        simulate_one(&vessel.model, &vessel.parameters(source).unwrap(), self.initial, &self.inputs)
    }

    /// Measured with white noise of standard deviation `noise` in every state; instruments from the nominal model.
    pub fn record(&self, vessel: &Vessel, noise: f64, normals: &mut Normals) -> Recording {
        let mut measured = self.states(vessel, Source::Value);
        measured.iter_mut().for_each(|y| *y += noise * normals.next());
        Recording {
            measured,
            instrument_states: self.states(vessel, Source::Nominal),
            exogenous: self.inputs.clone(),
            segments: self.segments.clone(),
        }
    }
}

/// One run: states (N+1) × 3, inputs N × 3.
#[derive(Clone)]
pub struct Recording {
    pub measured: Vec<f64>,
    pub instrument_states: Vec<f64>,
    pub exogenous: Vec<f64>,
    pub segments: Vec<usize>,
}

impl Recording {
    pub fn samples(&self) -> usize {
        self.measured.len() / 3 - 1
    }

    /// The same data with the measured states as instruments: least squares.
    pub fn with_own_instruments(&self) -> Self {
        Self { instrument_states: self.measured.clone(), ..self.clone() }
    }

    /// Samples `from..to` as a run of their own.
    pub fn segment(&self, from: usize, to: usize) -> Self {
        Self {
            measured: self.measured[3 * from..3 * (to + 1)].to_vec(),
            instrument_states: self.instrument_states[3 * from..3 * (to + 1)].to_vec(),
            exogenous: self.exogenous[3 * from..3 * to].to_vec(),
            segments: vec![0],
        }
    }
}

/// Up to [`LANES`] runs of equal length in lanes; unused lanes repeat the last run.
pub struct SideBySide {
    measured: Vec<Lane>,
    instrument_states: Vec<Lane>,
    exogenous: Vec<Lane>,
    segments: [Vec<usize>; LANES],
}

impl SideBySide {
    pub fn new(runs: &[&Recording]) -> Self {
        let run = |lane: usize| runs[lane.min(runs.len() - 1)];
        Self {
            measured: lanes(std::array::from_fn(|l| run(l).measured.as_slice())),
            instrument_states: lanes(std::array::from_fn(|l| run(l).instrument_states.as_slice())),
            exogenous: lanes(std::array::from_fn(|l| run(l).exogenous.as_slice())),
            segments: std::array::from_fn(|l| run(l).segments.clone()),
        }
    }

    pub fn batch<'a>(&'a self, model: &'a Model) -> Batch<'a> {
        Batch {
            model,
            measured: &self.measured,
            instrument_states: &self.instrument_states,
            instrument_exogenous: &self.exogenous,
            exogenous: &self.exogenous,
            segments: std::array::from_fn(|lane| self.segments[lane].as_slice()),
        }
    }
}

/// Rows of equal length into lanes.
pub fn lanes(rows: [&[f64]; LANES]) -> Vec<Lane> {
    (0..rows[0].len()).map(|i| Lane(std::array::from_fn(|lane| rows[lane][i]))).collect()
}
