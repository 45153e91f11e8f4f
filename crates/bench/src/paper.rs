//! The paper's study in memory.

use design::Candidates;
use identification::{Batch, moments};
use vessel::lanes::{interleave, lane};
use vessel::{DictionaryFile, Generator, Invalid, LANES, Lane, Realized, Source, Vessel, simulate};

/// Vessel and dictionary of the paper.
pub struct Paper {
    pub vessel: Vessel,
    pub truth: Vec<Lane>,
    pub nominal: Vec<Lane>,
    pub generator: Generator,
}

impl Paper {
    pub fn new() -> anyhow::Result<Self> {
        let vessel = Vessel::from_file(toml::from_str("preset = \"ljungberg-model-ship\"")?)?;
        let dictionary = toml::from_str(include_str!("../../../pipelines/paper/dictionary.toml"))?;
        let splat = |source| -> Result<Vec<Lane>, Invalid> {
            Ok(vessel.parameters(source)?.into_iter().map(Lane::splat).collect())
        };
        let (truth, nominal) = (splat(Source::Value)?, splat(Source::Nominal)?);
        let generator = generator(&vessel, &dictionary)?;
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
                simulate(&self.vessel.model, parameters, initial, &inputs, &[], &mut states);
                states
            };
            let (measured, instrument_states) = (states(&self.truth), states(&self.nominal));
            let batch = Batch {
                model: &self.vessel.model,
                measured: &measured,
                instrument_states: &instrument_states,
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

/// A generator of maneuvers without input files.
pub fn generator(vessel: &Vessel, dictionary: &DictionaryFile) -> Result<Generator, Invalid> {
    Generator::without_tables(vessel, dictionary)
}
