//! The vessels that a plan has to hold for, where the covariance of a model or the priors of its numbers state them.

use std::path::Path;

use files::Error;
use plan::Deviations;
use plan::voyage::{ErrorsFrom, Task};
use refusal::Invalid;
use ship::model::Vessel;

use super::file::PlanFile;
use super::task::kept;
use crate::documents::ModelDocument;
use crate::files::read_model;

/// `task` with the vessels within `safety.standard_errors` of the model at `model`, which `vessel` is of; as it is
/// without that key. Of a `vessel.toml` with forces the priors of its numbers count. `config` is at `file`.
///
/// # Errors
/// A `vessel.toml` of terms per sample, or whose numbers have no priors; a model without a covariance, or with one that is
/// not positive.
pub fn uncertain(
    [file, model]: [&Path; 2],
    config: &PlanFile,
    vessel: &Vessel,
    task: Task,
) -> Result<Task, Error> {
    let Some(errors) = config.safety.standard_errors else { return Ok(task) };
    let (deviations, from) = match (read_model(model)?, vessel.model.forces.is_some()) {
        (Some(document), _) => {
            let lacking = || lacking([file, model], errors, "which has none");
            (covariant(model, vessel, &document, errors)?.ok_or_else(lacking)?, ErrorsFrom::Covariance)
        }
        (None, true) => (by_priors(model, vessel, errors)?, ErrorsFrom::Priors),
        (None, false) => return Err(lacking([file, model], errors, "which is no model.json")),
    };
    Ok(Task { deviations: kept(vessel, deviations), errors_from: Some(from), ..task })
}

fn lacking([file, model]: [&Path; 2], errors: f64, found: &str) -> Error {
    let found = format!("{errors} and {}, {found}", model.display());
    let remedy = "give a model.json of `estimate pool`, or state `parameter_error`";
    Error::invalid(file, Invalid::new("`safety.standard_errors`", found, "a model with a covariance", remedy))
}

/// Within so many standard errors of the covariance of a model; `None` without one.
fn covariant(
    model: &Path,
    vessel: &Vessel,
    document: &ModelDocument,
    errors: f64,
) -> Result<Option<Deviations>, Error> {
    let of_forces = document.forces.as_ref().map(|own| &own.covariance);
    let Some(covariance) = of_forces.or(document.covariance.as_ref()) else { return Ok(None) };
    let place = |name: &str| covariance.names.iter().position(|own| own == name);
    let places: Vec<Option<usize>> = vessel.model.parameter_names().map(place).collect();
    let entry = |a: &Option<usize>, b: &Option<usize>| match (a, b) {
        (Some(a), Some(b)) => covariance.entries[a * covariance.names.len() + b],
        _ => 0.0,
    };
    let row = |a: &Option<usize>| places.iter().map(|b| entry(a, b)).collect();
    let rows: Vec<Vec<f64>> = places.iter().map(row).collect();
    let names: Vec<&str> = vessel.model.parameter_names().collect();
    let deviations = Deviations::ellipsoid(&rows, errors).map_err(|refused| {
        let found = format!("{}: {}", names[refused.parameter], refused.found);
        let remedy = "estimate the model again from more recordings, or state `parameter_error`";
        Error::invalid(model, Invalid::new("`data.covariance`", found, "a positive definite matrix", remedy))
    })?;
    Ok(Some(deviations))
}

/// Within so many standard deviations of the priors of a ship with forces.
fn by_priors(path: &Path, vessel: &Vessel, errors: f64) -> Result<Deviations, Error> {
    let parameters = vessel.model.forces.as_ref().map_or(&[][..], |own| own.forces.parameters());
    let deviations = parameters.iter().map(|parameter| {
        parameter.prior.ok_or_else(|| {
            let expected = "a `prior`, which `safety.standard_errors` of plan.toml counts in";
            let remedy = "state one, fix the number, or take `safety.parameter_error`";
            Error::refuse(path, format!("parameter `{}`", parameter.name), "no prior", expected, remedy)
        })
    });
    Ok(Deviations::independent(&deviations.collect::<Result<Vec<f64>, _>>()?, errors))
}
