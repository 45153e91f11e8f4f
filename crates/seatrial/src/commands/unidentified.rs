//! What `estimate` says where no run has an estimate.

use std::path::Path;

use identification::EstimateStatus;
use identification::runs::RunEstimators;
use study::estimates::Row;
use study::trajectories::TrajectoryReader;
use vessel::{DegreeOfFreedom, Vessel};

use crate::failure::Failure;

/// Refuses runs none of which has an estimate.
///
/// # Errors
/// No answer: why the first of measured runs is not identifiable; else how many searches ended nowhere, or the parameter that
/// no run excites. A block that is damaged.
pub fn refuse_if_none(
    estimators: &RunEstimators,
    file: &Path,
    reader: &TrajectoryReader,
    rows: &[Row],
) -> Result<(), Failure> {
    if rows.is_empty() || rows.iter().any(|r| r.estimate.is_some()) {
        return Ok(());
    }
    let searched = rows.iter().filter(|r| r.status == EstimateStatus::NotConverged).count();
    let first = reader.runs(0)?;
    let why = match first.first().and_then(|run| Some((run.run, estimators.collinear(run)?))) {
        Some((run, found)) => format!(
            "{} runs: found none that is identifiable (run {run}: {}), expected one; add maneuvers that vary these terms, \
             or use --estimator ls, or estimate pool --estimator auto",
            rows.len(),
            found.words
        ),
        None if searched > 0 => format!(
            "estimates by {}: found {searched} of {} runs whose search ended nowhere and no estimate, expected a minimum; \
             try `iv`, or a nominal model nearer to the vessel",
            rows[0].estimator,
            rows.len()
        ),
        None => unexcited(estimators.vessel, &rows[0]),
    };
    Err(Failure::NoAnswer(format!("{}: {why}", file.display())))
}

/// The parameter that the run does not excite.
fn unexcited(vessel: &Vessel, row: &Row) -> String {
    let degree = (0..3).find(|d| row.condition[*d].is_infinite()).unwrap_or(0);
    let (parameter, own) = (&row.weakest[degree], &vessel.model.degrees[degree]);
    let index = own.parameters.iter().position(|p| p == parameter).unwrap_or(0);
    format!(
        "parameter `{parameter}` ({}): found no run that excites it, expected its term `{}` to vary independently of \
         the others; add a maneuver in which it does",
        DegreeOfFreedom::ALL[degree].name(),
        own.terms[index].text
    )
}
