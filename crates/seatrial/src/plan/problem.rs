//! `plan --problem`: a lattice problem as it stands in a file.

use std::path::Path;

use artifact::{Digest, commit, stage_document};
use lattice::ProblemFile;
use serde_json::json;

use super::search::{Limits, search, status, steps, uses};
use crate::cli::provenance;
use crate::failure::Failure;
use crate::stage::Summary;
use study::documents::{PlanDocument, PlanPose};

/// Solves the problem in `file` and writes the plan to `out`.
///
/// # Errors
/// A file that is refused; no plan.
pub fn plan_problem(file: &Path, out: &Path, limits: &Limits) -> Result<Summary, Failure> {
    let refuse = |thing: &str, found: &str, expected: &str, remedy: &str| {
        Failure::refuse(file, thing, found, expected, remedy)
    };
    let bytes = std::fs::read(file).map_err(|e| artifact::Error::io(file, "read", e))?;
    let mut reader = serde_json::Deserializer::from_slice(&bytes);
    let parsed = <ProblemFile as serde::Deserialize>::deserialize(&mut reader)
        .and_then(|parsed| reader.end().map(|()| parsed))
        .map_err(|e| refuse("file", &e.to_string(), "a lattice problem in JSON", "correct it"))?;
    let problem = parsed.into_problem().map_err(|e| refuse(&e.thing, &e.found, &e.expected, &e.remedy))?;
    let solution = search(file, &problem, limits, |reason| reason.to_string())?;
    let (status, statement) = status(&problem, &solution);
    let pose = |p: lattice::Pose| PlanPose { i: p.i as u64, j: p.j as u64, h: p.layer as u64, mode: None };
    let document = PlanDocument {
        status,
        statement,
        cost_unit: "cost".into(),
        cost: solution.cost.primary,
        lower_bound: solution.lower_bound.primary,
        secondary: None,
        counts: uses(&problem, &solution),
        steps: steps(&problem, &solution, pose),
        voyage: None,
    };
    let mut provenance = provenance("plan");
    provenance.inputs.insert("problem".into(), Digest::of_bytes(&bytes));
    commit(vec![stage_document(out, &provenance, &document)?])?;
    let PlanDocument { status, cost, lower_bound, .. } = &document;
    Ok(Summary {
        line: format!("{}: {status}, cost {cost}, {} steps", out.display(), document.steps.len()),
        json: json!({"out": out, "status": status, "cost": cost, "lower_bound": lower_bound, "steps": document.steps.len()}),
    })
}
