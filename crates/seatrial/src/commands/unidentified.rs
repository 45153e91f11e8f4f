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
/// No answer, naming the parameter that no run excites, or how many searches ended nowhere.
pub fn refuse_if_none(file: &Path, vessel: &Vessel, rows: &[Row]) -> Result<(), Failure> {
    if rows.is_empty() || rows.iter().any(|r| r.estimate.is_some()) {
        return Ok(());
    }
    let searched = rows.iter().filter(|r| r.status == EstimateStatus::NotConverged).count();
    if searched > 0 {
        return Err(Failure::NoAnswer(format!(
            "{}: estimates by {}: found {searched} of {} runs whose search ended nowhere and no estimate, expected a minimum; \
             try `iv`, or a nominal model nearer to the vessel",
            file.display(),
            rows[0].estimator,
            rows.len()
        )));
    }
    let unexcited = (0..3).find(|d| rows[0].condition[*d].is_infinite()).unwrap_or(0);
    let parameter = &rows[0].weakest[unexcited];
    let index = vessel.model.degrees[unexcited].parameters.iter().position(|p| p == parameter).unwrap_or(0);
    Err(Failure::NoAnswer(format!(
        "{}: parameter `{parameter}` ({}): found no run that excites it, expected its term `{}` to vary independently of \
         the others; add a maneuver in which it does",
        file.display(),
        DegreeOfFreedom::ALL[unexcited].name(),
        vessel.model.degrees[unexcited].terms[index].text
    )))
}

/// Refuses measured runs none of which is identified, in the words of the first.
///
/// # Errors
/// No answer; a block that is damaged.
pub fn refuse_if_all_collinear(
    estimators: &RunEstimators,
    file: &Path,
    reader: &TrajectoryReader,
    rows: &[Row],
) -> Result<(), Failure> {
    if rows.is_empty() || rows.iter().any(|r| r.estimate.is_some()) {
        return Ok(());
    }
    let runs = reader.runs(0)?;
    let Some((run, found)) = runs.first().and_then(|run| Some((run.run, estimators.collinear(run)?))) else {
        return Ok(());
    };
    Err(Failure::NoAnswer(format!(
        "{}: {} runs: found none that is identifiable (run {run}: {}), expected one; add maneuvers that vary these terms, \
         or use --estimator ls, or estimate pool --estimator auto",
        file.display(),
        rows.len(),
        found.words
    )))
}
