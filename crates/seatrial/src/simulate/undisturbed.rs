//! Undisturbed trajectories: the dictionary and the validation maneuvers.

use std::collections::BTreeMap;
use std::path::Path;

use artifact::{Provenance, encode_block};
use vessel::{Exceeded, Generator, Limits, Realized, Source, Vessel, check_diverged, simulate_one};

use super::{diverged, exogenous, publish, refuse_endless, writer};
use crate::failure::Failure;
use crate::ordered::ordered;
use crate::progress::Progress;
use study::trajectories::{BlockBuilder, NewRun};

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
    /// Simulates every maneuver from its own initial state into `out`, but generated ones that exceed their limits.
    ///
    /// # Errors
    /// A maneuver of zero samples or that the model cannot hold; a simulation that diverges; limits that no generated
    /// maneuver keeps; output that fails.
    pub fn write(&self, out: &Path, provenance: &Provenance, quiet: bool) -> Result<Written, Failure> {
        let count = self.generator.maneuvers().len();
        let names: Vec<String> = self.generator.maneuvers().iter().map(|m| m.name.clone()).collect();
        let parameters =
            self.vessel.parameters(self.source).map_err(|e| Failure::invalid(self.vessel_file, &e))?;
        let (layout, mut writer) = writer(out, self.vessel, provenance)?;
        let schema = layout.schema();
        let progress = Progress::new("maneuvers", count, quiet);
        let mut written = Written::default();
        let work = |block: usize| {
            let mut builder = BlockBuilder::new(&layout, &names, self.vessel.sample_rate_hz);
            let mut found = Written::default();
            for index in block * BLOCK..count.min((block + 1) * BLOCK) {
                found.add(&self.push(index, &parameters, &mut builder)?);
            }
            progress.advance(BLOCK);
            let encoded =
                if found.maneuvers > 0 { Some(encode_block(&schema, &builder.table())?) } else { None };
            Ok::<_, Failure>((encoded, found))
        };
        ordered(0..count.div_ceil(BLOCK), work, |(block, found)| {
            written.merge(found);
            Ok(block.map_or(Ok(()), |block| writer.push(block))?)
        })?;
        if written.kept == 0 && !written.left_out.is_empty() {
            return Err(self.nothing_within(&written));
        }
        publish(writer)?;
        Ok(written)
    }

    fn push(&self, index: usize, parameters: &[f64], builder: &mut BlockBuilder) -> Result<Pushed, Failure> {
        match self.generator.limits(index) {
            Some(limits) => self.push_within(index, limits, parameters, builder),
            None => self.push_written(index, parameters, builder).map(Pushed::Written),
        }
    }

    /// A generated maneuver, unless it exceeds its limits.
    fn push_within(
        &self,
        index: usize,
        limits: &Limits,
        parameters: &[f64],
        builder: &mut BlockBuilder,
    ) -> Result<Pushed, Failure> {
        let samples =
            self.generator.samples(index).map_err(|e| Failure::invalid(self.dictionary_file, &e))?;
        let (initial, exogenous) = match judge(self.vessel, self.generator, index, limits, samples) {
            Judged::Within { initial, exogenous } => (initial, exogenous),
            Judged::Exceeds(exceeded) => return Ok(Pushed::Exceeds(exceeded)),
            Judged::Unsteady => return Ok(Pushed::Unsteady),
        };
        let states = simulate_one(&self.vessel.model, parameters, initial, &exogenous);
        if check_diverged(states.iter().copied()).is_some() {
            return Ok(Pushed::Unsteady);
        }
        self.push_run(index, &exogenous, &states, builder);
        Ok(Pushed::Kept(samples))
    }

    fn push_run(&self, index: usize, exogenous: &[f64], states: &[f64], builder: &mut BlockBuilder) {
        builder.push(&NewRun {
            design: self.design,
            run: index as u32,
            segments: &[(index, 0)],
            exogenous,
            measured: states,
            states,
        });
    }

    /// Why no generated maneuver was left: the limit that most of them exceed, and the least that one exceeds it by.
    fn nothing_within(&self, written: &Written) -> Failure {
        let tightest = written.left_out.iter().max_by(|a, b| a.1.count.cmp(&b.1.count).then(b.0.cmp(a.0)));
        let (name, about) =
            tightest.map_or(("", LeftOut::default()), |(name, about)| (name.as_str(), *about));
        let all: usize = written.left_out.values().map(|l| l.count).sum();
        if name == UNSTEADY {
            return Failure::refuse(
                self.dictionary_file,
                "`generate`",
                &format!("no candidate of {all} that inputs hold steady"),
                "at least one",
                "give `speed_m_s` and limits that the vessel can reach, or other `kinds`",
            );
        }
        Failure::refuse(
            self.dictionary_file,
            &format!("`generate.limits.{name}`"),
            &format!(
                "{}, which is the tightest: {} of {all} candidates exceed it most, the nearest reaches {:.4}, and none \
                 keeps all limits",
                about.allowed, about.count, about.nearest
            ),
            "limits that at least one candidate keeps",
            &format!("raise `{name}`, or draw more `candidates`"),
        )
    }

    fn push_written(
        &self,
        index: usize,
        parameters: &[f64],
        builder: &mut BlockBuilder,
    ) -> Result<usize, Failure> {
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
        self.push_run(index, &exogenous, &states, builder);
        Ok(samples)
    }
}

/// A generated maneuver beside its limits.
pub(crate) enum Judged {
    /// It keeps them: initial state, N × exogenous.
    Within { initial: [f64; 3], exogenous: Vec<f64> },
    /// It does not.
    Exceeds(Exceeded),
    /// No inputs hold its motion.
    Unsteady,
}

/// Judges maneuver `index` in `samples` samples by what its inputs were made with, whatever moves the vessel.
pub(crate) fn judge(
    vessel: &Vessel,
    generator: &Generator,
    index: usize,
    limits: &Limits,
    samples: usize,
) -> Judged {
    let Ok(Realized { initial, inputs }) = generator.realize(index, samples) else { return Judged::Unsteady };
    let exogenous = exogenous(&vessel.model, &inputs);
    let states = simulate_one(&vessel.model, generator.parameters(), initial, &exogenous);
    match limits.exceeded(&vessel.model, &states, &inputs) {
        Some(exceeded) => Judged::Exceeds(exceeded),
        None => Judged::Within { initial, exogenous },
    }
}

/// What became of one maneuver, with its samples where it was written.
enum Pushed {
    /// Written by hand: not held to limits.
    Written(usize),
    Kept(usize),
    Exceeds(Exceeded),
    Unsteady,
}

/// What was written, and what was left out why.
#[derive(Clone, Debug, Default)]
pub struct Written {
    /// Number of maneuvers.
    pub maneuvers: usize,
    /// Their samples.
    pub samples: usize,
    /// How many of them are generated.
    pub kept: usize,
    /// Generated maneuvers that were left out, by the limit that they exceed most.
    pub left_out: BTreeMap<String, LeftOut>,
}

/// Maneuvers left out for one reason.
#[derive(Clone, Copy, Debug, Default)]
pub struct LeftOut {
    /// Their number.
    pub count: usize,
    /// The limit.
    pub allowed: f64,
    /// The smallest of what they reach.
    pub nearest: f64,
}

/// Name of the reason that no limit is.
const UNSTEADY: &str = "no steady inputs";

impl Written {
    fn add(&mut self, pushed: &Pushed) {
        match pushed {
            Pushed::Written(samples) | Pushed::Kept(samples) => {
                self.maneuvers += 1;
                self.samples += samples;
                self.kept += usize::from(matches!(pushed, Pushed::Kept(_)));
            }
            Pushed::Exceeds(Exceeded { limit, allowed, found }) => {
                self.leave_out(limit, LeftOut { count: 1, allowed: *allowed, nearest: *found })
            }
            Pushed::Unsteady => self.leave_out(UNSTEADY, LeftOut { count: 1, ..LeftOut::default() }),
        }
    }

    fn leave_out(&mut self, name: &str, about: LeftOut) {
        self.left_out
            .entry(name.to_owned())
            .and_modify(|known| {
                known.count += about.count;
                known.nearest = known.nearest.min(about.nearest);
            })
            .or_insert(about);
    }

    fn merge(&mut self, other: Self) {
        self.maneuvers += other.maneuvers;
        self.samples += other.samples;
        self.kept += other.kept;
        other.left_out.iter().for_each(|(name, about)| self.leave_out(name, *about));
    }

    /// `; left out of 3000 generated: 12 by u_m_s, …`, or nothing.
    pub fn told(&self) -> String {
        let out: usize = self.left_out.values().map(|l| l.count).sum();
        if out == 0 {
            return String::new();
        }
        let reasons: Vec<String> =
            self.left_out.iter().map(|(name, l)| format!("{} by {name}", l.count)).collect();
        format!("; {out} of {} generated left out: {}", out + self.kept, reasons.join(", "))
    }
}
