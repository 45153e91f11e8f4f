//! `plan --problem`: a lattice problem from a file.

use std::path::Path;

use files::{Provenance, commit, read_json, stage_document};
use plan::lattice::{ProblemFile, plan};
use serde_json::json;
use study::documents::PlanDocument;
use study::plan::{no_plan, of_problem, out_of_time, too_large};

use super::Limits;
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
    let (parsed, digest) = read_json::<ProblemFile>(file)?;
    let demand = parsed.demand();
    if demand.bytes() > u128::from(limits.memory_bytes) {
        return Err(too_large(file, &demand).into());
    }
    let problem =
        parsed.into_problem_while(&|| limits.keep_going()).map_err(|e| Failure::invalid(file, &e))?;
    let problem = problem.ok_or_else(|| out_of_time(file, "the layout of the map"))?;
    let solution = plan(&problem, &limits.options(), &mut *limits.before_writing().watch())
        .map_err(|why| no_plan(file, &why))?;
    let document = of_problem(&problem, &solution);
    provenance.inputs.insert("problem".into(), digest);
    commit(vec![stage_document(out, &provenance, &document)?])?;
    let PlanDocument { status, cost, lower_bound, gap, .. } = &document;
    let steps = document.steps.len();
    let details =
        json!({"status": status, "cost": cost, "lower_bound": lower_bound, "gap": gap, "steps": steps});
    Ok(Summary::of(out, format!("{}, cost {cost}, {steps} steps", document.known()), details))
}
