//! Models that are exported: a `model.json` with its errors and ranges, or a `vessel.toml`.

use std::path::Path;

use artifact::{Error, Provenance, read_document};
use export::{Knowledge, Origin, Portable};
use model::{Source, Vessel};

use crate::documents::{AverageDocument, AverageMember, ModelDocument};
use crate::files::{is_average, read_any_vessel, read_model};
use crate::rate::{at_rate, tried};

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
    if !is_average(path) {
        let vessel = read_any_vessel(path, provenance)?;
        return Ok(vec![portable(path, (vessel, read_model(path)?), (source, rate_hz), provenance)?]);
    }
    let average = read_document::<AverageDocument>(path)?;
    provenance.written("vessel", path, average.digest)?;
    let one = |member: AverageMember| {
        let vessel = member.model.vessel().map_err(|e| crate::invalid(path, &e))?;
        portable(path, (vessel, Some(member.model)), (source, rate_hz), provenance)
    };
    average.data.members.into_iter().map(one).collect()
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
    portable().map_err(|e| crate::invalid(path, &e))
}

/// Standard errors, the ranges of the data, and warnings about the model.
fn knowledge(model: &ModelDocument) -> Knowledge {
    let terms = model.degrees.iter().flat_map(|degree| &degree.parameters);
    let terms = terms.map(|own| (&own.name, own.standard_error));
    let forces = model.forces.iter().flat_map(|own| &own.parameters);
    let all = terms.chain(forces.map(|own| (&own.name, own.standard_error)));
    Knowledge {
        standard_errors: all.filter_map(|(name, error)| Some((name.clone(), error?))).collect(),
        covered: model.covered.iter().map(|own| (own.name.clone(), [own.low, own.high])).collect(),
        parts: None,
        notes: model.statements.clone(),
    }
}
