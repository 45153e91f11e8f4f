//! The paper's study in memory.

use design::Candidates;
use maneuver::{Generator, Realized};
use numerics::lanes::{interleave, lane};
use numerics::{LANES, Lane};
use refusal::Invalid;
use regression::{Batch, moments};
use ship::engine::{Current, Disturbances, Measurement, Streams, Weather, simulate, simulate_one};
use ship::model::{Source, Vessel};

/// Vessel and dictionary of the paper.
pub struct Paper {
    pub vessel: Vessel,
    pub truth: Vec<Lane>,
    pub nominal: Vec<Lane>,
    pub generator: Generator,
}

impl Paper {
    pub fn new() -> anyhow::Result<Self> {
        Self::of("preset = \"ljungberg-model-ship\"")
    }

    fn of(file: &str) -> anyhow::Result<Self> {
        let vessel = Vessel::from_file(toml::from_str(file)?)?;
        let dictionary = toml::from_str(include_str!("../../../../pipelines/scenarios/dictionary.toml"))?;
        let splat = |source| -> Result<Vec<Lane>, Invalid> {
            Ok(vessel.parameters(source)?.into_iter().map(Lane::splat).collect())
        };
        let (truth, nominal) = (splat(Source::Value)?, splat(Source::Nominal)?);
        let generator = Generator::without_tables(&vessel, &dictionary)?;
        Ok(Self { vessel, truth, nominal, generator })
    }

    /// Moments of the dictionary's maneuvers as candidates.
    pub fn candidates(&self) -> anyhow::Result<Candidates> {
        self.candidates_of(&self.generator)
    }

    /// Moments of every maneuver of `generator` (all of one length) as candidates.
    pub fn candidates_of(&self, generator: &Generator) -> anyhow::Result<Candidates> {
        let mut candidates = Candidates::new(vec![5, 4, 4]);
        let count = generator.maneuvers().len();
        for start in (0..count).step_by(LANES) {
            let index = |lane: usize| (start + lane).min(count - 1);
            let samples = generator.samples(start)?;
            let maneuvers: Vec<Realized> =
                (0..LANES).map(|lane| generator.realize(index(lane), samples)).collect::<Result<_, _>>()?;
            let inputs = interleave(&maneuvers.iter().map(|m| m.inputs.as_slice()).collect::<Vec<_>>());
            let initial = [0, 1, 2].map(|d: usize| lane(LANES, |i| maneuvers[i].initial[d]));
            let states = |parameters: &[Lane]| {
                let mut states = vec![Lane::ZERO; 3 * (samples + 1)];
                simulate(&self.vessel.model, parameters, initial, &inputs, &Weather::CALM, &mut states);
                states
            };
            let (measured, instrument_states) = (states(&self.truth), states(&self.nominal));
            let batch = Batch {
                model: &self.vessel.model,
                measured: &measured,
                instrument_states: &instrument_states,
                instrument_exogenous: &inputs,
                exogenous: &inputs,
                segments: [&[0]; LANES],
            };
            for found in moments(&batch).into_iter().take(count - start) {
                candidates.push(&found.matrices.concat())?;
            }
        }
        Ok(candidates)
    }
}

/// Samples per maneuver of the optimized experiment: the paper study's design.
pub const OPTIMIZED: [(usize, usize); 6] = [(0, 193), (4, 43), (5, 229), (6, 101), (7, 85), (10, 349)];

/// The optimized experiment among the paper's disturbances.
pub struct Experiment<'a> {
    pub paper: &'a Paper,
    /// State at the first sample.
    pub initial: [f64; 3],
    /// N × 3.
    pub inputs: Vec<f64>,
    /// First sample of every segment.
    pub segments: Vec<usize>,
    disturbances: Disturbances,
    streams: Streams,
}

impl<'a> Experiment<'a> {
    pub fn new(paper: &'a Paper) -> anyhow::Result<Self> {
        let (mut inputs, mut segments) = (Vec::new(), Vec::new());
        for (maneuver, samples) in OPTIMIZED {
            segments.push(inputs.len() / 3);
            inputs.extend(paper.generator.realize(maneuver, samples)?.inputs);
        }
        let initial = paper.generator.realize(OPTIMIZED[0].0, 1)?.initial;
        let std = 0.025_f64.sqrt();
        let measurement = Measurement { std_u_m_s: std, std_v_m_s: std, std_r_rad_s: std };
        let disturbances = Disturbances { current: Current::White { std_m_s: std }, measurement };
        Ok(Self { paper, initial, inputs, segments, disturbances, streams: Streams::new(1, "bench") })
    }

    pub fn samples(&self) -> usize {
        self.inputs.len() / 3
    }

    /// Simulates and measures [`LANES`] runs from number `first` on, (N+1) × 3.
    pub fn measured(&self, first: u32) -> Vec<Lane> {
        let runs = std::array::from_fn(|lane| first + lane as u32);
        let current = self.disturbances.current(&self.streams, runs, self.samples(), 8.0);
        let mut states = vec![Lane::ZERO; 3 * (self.samples() + 1)];
        let initial = self.initial.map(Lane::splat);
        let Paper { vessel, truth, .. } = self.paper;
        let weather = Weather { current: &current, ..Weather::CALM };
        simulate(&vessel.model, truth, initial, &self.inputs, &weather, &mut states);
        self.disturbances.measure(&self.streams, runs, &mut states);
        states
    }

    /// What instruments are made of: states of the model with the nominal parameters, (N+1) × 3.
    pub fn nominal_states(&self) -> Vec<f64> {
        let vessel = &self.paper.vessel;
        simulate_one(&vessel.model, &vessel.nominal, self.initial, &self.inputs)
    }
}
