//! A vessel's model as source text for other tools: Python, C, MATLAB or Octave, and a Functional Mock-up
//! Unit.
//!
//! [`Portable`] is the model in a form common to all languages: channels, parameters and equations under
//! names that are identifiers everywhere. A target turns it into text in memory; the caller writes the files
//! and builds the library.
//!
//! The generated code computes what [`ship::engine::Compiled::step`] does in the same order, so that both agree to the last bit
//! where a processor does not fuse multiplication and addition.

mod fmi;
mod languages;
mod portable;
mod ship;
mod target;
pub mod text;

use std::path::Path;

use files::{Error, Provenance};
use refusal::Invalid;
use study::at_rate;
use study::documents::{AverageMember, ModelDocument};
use study::files::{read_any_vessel, read_model};

use ::ship::engine::{Divided, check_diverged, simulate_one};
use ::ship::model::{Actuator, Source, Vessel};

pub use fmi::{COMPILED_WITH, PLATFORM};
pub use portable::{Channel, Knowledge, Origin, Parameter, Portable, Range, Summand, Tied};
pub use ship::Ship;
pub use target::Target;
pub use text::{Identifiers, file_name, fill};

/// Reads the model in `path` for other tools and notes its digest: with the values of `source`, or the best
/// available, at its own rate or at `rate_hz`. An average gives several, whose trajectories are to be averaged.
///
/// # Errors
/// See [`read_any_vessel`]; a parameter without such a value; a dead time; a rate that the model cannot have.
pub fn read_portable(
    path: &Path,
    source: Option<Source>,
    rate_hz: Option<f64>,
    provenance: &mut Provenance,
) -> Result<Vec<Portable>, Error> {
    let (vessel, mut model) = (read_any_vessel(path, provenance)?, read_model(path)?);
    let members = model.as_mut().map(|model| std::mem::take(&mut model.members)).unwrap_or_default();
    if members.is_empty() {
        return Ok(vec![portable(path, (vessel, model), (source, rate_hz), provenance)?]);
    }
    let one = |member: AverageMember| {
        let vessel = member.model.vessel().map_err(|e| study::invalid(path, &e))?;
        portable(path, (vessel, Some(member.model)), (source, rate_hz), provenance)
    };
    members.into_iter().map(one).collect()
}

/// `vessel`, or what is known of its `model`, read from `path`.
fn portable(
    path: &Path,
    (vessel, model): (Vessel, Option<ModelDocument>),
    (source, rate_hz): (Option<Source>, Option<f64>),
    provenance: &mut Provenance,
) -> Result<Portable, Error> {
    let vessel = at_rate(path, vessel, rate_hz, provenance)?;
    // A fit of simulated runs knows the true values, too; a model is its estimates.
    let best = if model.is_some() { Source::Nominal } else { vessel.best_known() };
    let source = source.unwrap_or(best);
    let estimates = model.is_some() && source == Source::Nominal;
    let digest = provenance.inputs.get("vessel").map(ToString::to_string);
    let origin = Origin {
        producer: format!("seatrial {}", provenance.producer),
        file: path.file_name().unwrap_or_default().to_string_lossy().into_owned(),
        digest: digest.unwrap_or_default(),
        values: if estimates { "estimates".to_owned() } else { format!("{} values", source.name()) },
    };
    let mut known = model.as_ref().map_or_else(Knowledge::default, knowledge);
    let within = model.as_ref().map_or_else(|| vessel.clone(), |model| model.kept_to_data(vessel.clone()));
    let portable = || {
        known.parts = tried(&within, &vessel.parameters(source)?)?;
        Portable::new(&vessel, source, &known, origin)
    };
    portable().map_err(|e| study::invalid(path, &e))
}

/// Standard errors, the ranges of the data, and warnings about the model.
fn knowledge(model: &ModelDocument) -> Knowledge {
    let terms = model.degrees.iter().flat_map(|degree| &degree.parameters);
    let terms = terms.map(|parameter| (&parameter.name, parameter.standard_error));
    let forces = model.forces.iter().flat_map(|force| &force.parameters);
    let all = terms.chain(forces.map(|parameter| (&parameter.name, parameter.standard_error)));
    Knowledge {
        standard_errors: all.filter_map(|(name, error)| Some((name.clone(), error?))).collect(),
        covered: model.covered.iter().map(|range| (range.name.clone(), [range.low, range.high])).collect(),
        parts: None,
        notes: model.statements.clone(),
    }
}

/// Samples of the run that a model is tried with, and how many have the same inputs.
const SAMPLES: usize = 5_000;
const HELD: usize = 100;

/// How well the parts of the steps of `vessel` follow these in a run from the middle of her known range of motion, or from rest,
/// whose inputs go to other settings within their ranges every hundred samples; `None` where samples are no parts of steps.
fn tried(vessel: &Vessel, parameters: &[f64]) -> Result<Option<String>, Invalid> {
    let Some(mut divided) = Divided::new(&vessel.model) else { return Ok(None) };
    let inputs = vessel.model.inputs;
    let range = |(i, actuator): (usize, &Actuator)| {
        actuator.range.ok_or_else(|| {
            let thing = format!("input `{}`", vessel.model.input_variables()[i].name);
            let expected = "a `range`, within which a faster step is tried";
            Invalid::new(thing, "no `range`", expected, "state it, or export at the vessel's own rate")
        })
    };
    let ranges = vessel.actuators.iter().enumerate().map(range).collect::<Result<Vec<_>, _>>()?;
    let row = |k: usize| {
        let mut row = vec![0.0; inputs];
        for (i, (to, [low, high])) in row.iter_mut().zip(&ranges).enumerate() {
            // Multiples of square roots, which no setting repeats.
            let share = ((k / HELD + 1) as f64 * (2.0 + 3.0 * i as f64).sqrt()).fract();
            *to = low + (high - low) * share;
        }
        row
    };
    let settings: Vec<f64> = (0..SAMPLES).flat_map(row).collect();
    let exogenous = vessel.model.undisturbed(&settings);
    let initial = vessel.motion.map_or([0.0; 3], |ranges| ranges.map(|[low, high]| 0.5 * (low + high)));
    let states = simulate_one(&vessel.model, parameters, initial, &exogenous);
    if let Some(at) = check_diverged(states.iter().copied()) {
        return Err(at.invalid("model in the run that a faster step is tried in", vessel.sample_rate_hz));
    }
    divided.add(&vessel.model, parameters, &exogenous, &states);
    divided.add_range(vessel, parameters);
    divided.statement().map(Some)
}
