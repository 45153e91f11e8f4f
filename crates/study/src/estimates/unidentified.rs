//! The message if no run has an estimate.

use estimation::EstimateStatus;
use estimation::runs::RunEstimators;
use files::Error;
use ship::model::{DegreeOfFreedom, Vessel};

use super::Row;
use crate::trajectories::TrajectoryReader;

/// Why none of the runs has an estimate: the reason for the first of measured runs; else the number of failed
/// searches, or the parameter that no run excites. `None` if some have one.
///
/// # Errors
/// A damaged block.
pub fn unidentified(
    estimators: &RunEstimators,
    reader: &TrajectoryReader,
    rows: &[Row],
) -> Result<Option<String>, Error> {
    if rows.is_empty() || rows.iter().any(|r| r.estimate.is_some()) {
        return Ok(None);
    }
    let searched = rows.iter().filter(|r| r.status == EstimateStatus::NotConverged).count();
    let first = reader.runs(0)?;
    let why = match first.first().and_then(|run| Some((run.run, estimators.collinear(run)?))) {
        Some((run, found)) => format!(
            "{} runs: found none that is identifiable (run {run}: {}), expected one; add maneuvers that vary these terms, \
             or hold them near the nominal model: estimate pool --prior 0.03",
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
    Ok(Some(why))
}

/// The parameter that the run does not excite.
fn unexcited(vessel: &Vessel, row: &Row) -> String {
    if vessel.model.forces.is_some() {
        return format!(
            "parameter `{}`: found no run and no prior that determines it, expected one; add a maneuver that does, or a `prior`, \
             or fix it",
            row.weakest[0]
        );
    }
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
