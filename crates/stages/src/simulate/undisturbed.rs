//! Undisturbed trajectories: the dictionary and the validation maneuvers.

use std::path::Path;

use artifact::{Provenance, encode_block};
use vessel::{Generator, Source, Vessel, check_diverged, simulate_one};

use super::{diverged, exogenous, publish, refuse_endless, writer};
use crate::failure::Failure;
use crate::ordered::ordered;
use crate::progress::Progress;
use crate::trajectories::{BlockBuilder, NewRun};

/// What to simulate.
pub struct Undisturbed<'a> {
    /// The vessel.
    pub vessel: &'a Vessel,
    /// Its file, for messages.
    pub vessel_file: &'a Path,
    /// The dictionary's file, for messages.
    pub dictionary_file: &'a Path,
    /// The maneuvers, each a run.
    pub generator: &'a Generator,
    /// Which parameters move the vessel.
    pub source: Source,
    /// Name of the design in the table.
    pub design: &'static str,
}

/// Maneuvers per block.
const BLOCK: usize = 64;

impl Undisturbed<'_> {
    /// Simulates every maneuver from its own initial state into `out`. Returns the number of maneuvers and samples.
    ///
    /// # Errors
    /// A maneuver of zero samples or that the model cannot hold; a simulation that diverges; output that fails.
    pub fn write(&self, out: &Path, provenance: &Provenance, quiet: bool) -> Result<(usize, usize), Failure> {
        let count = self.generator.maneuvers().len();
        let names: Vec<String> = self.generator.maneuvers().iter().map(|m| m.name.clone()).collect();
        let parameters =
            self.vessel.parameters(self.source).map_err(|e| Failure::invalid(self.vessel_file, &e))?;
        let (layout, mut writer) = writer(out, self.vessel, provenance)?;
        let schema = layout.schema();
        let progress = Progress::new("maneuvers", count, quiet);
        let mut total = 0;
        let work = |block: usize| {
            let mut builder = BlockBuilder::new(&layout, &names, self.vessel.sample_rate_hz);
            let mut samples = 0;
            for index in block * BLOCK..count.min((block + 1) * BLOCK) {
                samples += self.push(index, &parameters, &mut builder)?;
            }
            progress.advance(BLOCK);
            Ok::<_, Failure>((encode_block(&schema, &builder.table())?, samples))
        };
        ordered(0..count.div_ceil(BLOCK), work, |(block, samples)| {
            total += samples;
            Ok(writer.push(block)?)
        })?;
        publish(writer)?;
        Ok((count, total))
    }

    fn push(&self, index: usize, parameters: &[f64], builder: &mut BlockBuilder) -> Result<usize, Failure> {
        let invalid = |e| Failure::invalid(self.dictionary_file, &e);
        let samples = self.generator.samples(index).map_err(invalid)?;
        let thing = format!("maneuver `{}`, `duration_s`", self.generator.maneuvers()[index].name);
        refuse_endless(self.dictionary_file, &thing, samples)?;
        let maneuver = self.generator.realize(index, samples).map_err(invalid)?;
        let exogenous = exogenous(&self.vessel.model, &maneuver.inputs);
        let states = simulate_one(&self.vessel.model, parameters, maneuver.initial, &exogenous);
        if let Some(at) = check_diverged(states.iter().copied()) {
            let what = format!("model in maneuver `{}`", self.generator.maneuvers()[index].name);
            return Err(diverged(self.vessel_file, &what, at));
        }
        builder.push(&NewRun {
            design: self.design,
            run: index as u32,
            segments: &[(index, 0)],
            exogenous: &exogenous,
            measured: &states,
            states: &states,
        });
        Ok(samples)
    }
}
