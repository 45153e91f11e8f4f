//! The vessels that a plan has to hold for, where the covariance of a model states them.

use std::path::Path;

use artifact::Error;
use model::Vessel;
use refusal::Invalid;
use trial::Deviations;
use trial::voyage::Task;

use super::file::PlanFile;
use crate::files::read_model;

/// `task` with the vessels within `safety.standard_errors` of the model at `model`, which `vessel` is of; as it is
/// without that key. `config` is at `file`.
///
/// # Errors
/// A `vessel.toml`, which has no covariance; a model without one, or with one that is not positive.
pub fn uncertain(
    [file, model]: [&Path; 2],
    config: &PlanFile,
    vessel: &Vessel,
    task: Task,
) -> Result<Task, Error> {
    let Some(errors) = config.safety.standard_errors else { return Ok(task) };
    let lacking = |found: &str| {
        let found = format!("{errors} and {}, {found}", model.display());
        let remedy = "give a model.json of `estimate pool`, or state `parameter_error`";
        Error::invalid(
            file,
            Invalid::new("`safety.standard_errors`", found, "a model with a covariance", remedy),
        )
    };
    let document = read_model(model)?.ok_or_else(|| lacking("which is no model.json"))?;
    let covariance = document.covariance.as_ref().ok_or_else(|| lacking("which has none"))?;
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
    Ok(Task { deviations, ..task })
}
