//! `plan --problem`: a lattice problem as it stands in a file.

use std::path::Path;

use artifact::{Digest, Error, Provenance, commit, stage_document};
use lattice::{ProblemFile, plan};
use serde_json::json;
use study::documents::PlanDocument;
use study::plan::of_problem;

use super::limits::Limits;
use super::refusals::no_plan;
use crate::failure::Failure;
use crate::stage::Summary;

/// Solves the problem in `file` and writes the plan to `out`.
///
/// # Errors
/// A file that is refused; no plan.
pub fn plan_problem(
    file: &Path,
    out: &Path,
    limits: &Limits,
    mut provenance: Provenance,
) -> Result<Summary, Failure> {
    let bytes = std::fs::read(file).map_err(|e| Error::io(file, "read", e))?;
    let mut reader = serde_json::Deserializer::from_slice(&bytes);
    let parsed = <ProblemFile as serde::Deserialize>::deserialize(&mut reader)
        .and_then(|parsed| reader.end().map(|()| parsed))
        .map_err(|e| {
            Failure::refuse(file, "file", &e.to_string(), "a lattice problem in JSON", "correct it")
        })?;
    let problem = parsed.into_problem().map_err(|e| Failure::invalid(file, &e))?;
    let solution =
        plan(&problem, &limits.options(), &mut *limits.watch()).map_err(|why| no_plan(file, &why))?;
    let document = of_problem(&problem, &solution);
    provenance.inputs.insert("problem".into(), Digest::of_bytes(&bytes));
    commit(vec![stage_document(out, &provenance, &document)?])?;
    let PlanDocument { status, cost, lower_bound, .. } = &document;
    let steps = document.steps.len();
    let told = json!({"status": status, "cost": cost, "lower_bound": lower_bound, "steps": steps});
    Ok(Summary::of(out, format!("{}, cost {cost}, {steps} steps", status.name()), told))
}
