use std::path::Path;

use vessel::{DegreeOfFreedom, Vessel};

use crate::failure::Failure;
use identification::EstimateStatus as Status;
use study::estimates::Row;

/// Refuses runs none of which has an estimate.
///
/// # Errors
/// No answer, naming the parameter that no run excites, or how many searches ended nowhere.
pub fn refuse_if_none(file: &Path, vessel: &Vessel, rows: &[Row]) -> Result<(), Failure> {
    if rows.is_empty() || rows.iter().any(|r| r.estimate.is_some()) {
        return Ok(());
    }
    let searched = rows.iter().filter(|r| r.status == Status::NotConverged).count();
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
