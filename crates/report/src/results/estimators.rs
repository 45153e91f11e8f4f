//! Every estimator under several kinds of disturbance.

use std::path::PathBuf;

use artifact::Error;
use identification::Estimator;
use study::documents::{DesignScores, EstimatorScores, ValidationDocument};

use super::folder::{documents, label, left_out, seed};
use super::table::{Table, quantile, whole};

/// The design whose errors the table has.
const DESIGN: &str = "optimized";

pub(super) fn section(folders: &[PathBuf]) -> Result<Option<String>, Error> {
    let (found, missing) = documents::<ValidationDocument>(folders, "validation.json")?;
    let compared: Vec<&[EstimatorScores]> =
        found.iter().map(|(_, v)| v.data.compared.as_deref().unwrap_or_default()).collect();
    let given = |estimator: &Estimator| compared.iter().any(|scores| of(scores, *estimator).is_some());
    let estimators: Vec<Estimator> = Estimator::OF_RUNS.into_iter().filter(given).collect();
    let heads: Vec<String> = estimators.iter().map(|estimator| format!("`{estimator}`")).collect();
    let heads: Vec<&str> =
        ["scenario", "trials", "seed"].into_iter().chain(heads.iter().map(String::as_str)).collect();
    let mut table = Table::new(&heads);
    for ((folder, _), scores) in found.iter().zip(&compared) {
        let own: Vec<Option<&DesignScores>> =
            estimators.iter().map(|estimator| of(scores, *estimator)).collect();
        let runs = own.iter().flatten().next().map(|d| d.runs);
        let median = |d: &DesignScores| quantile(d.parameter_error.median, d.parameter_error.median_interval);
        let errors = own.iter().map(|d| d.map_or("–".to_owned(), median));
        table.row(
            &[label(folder), whole(runs), whole(seed(folder)?)].into_iter().chain(errors).collect::<Vec<_>>(),
        );
    }
    let note = left_out(&missing, "not computed");
    Ok(table.text().map(|table| {
        format!(
            "## Estimators\n\nMedian parameter error of the {DESIGN} trial; a trial without an estimate counts as infinite.\n\n{table}{note}"
        )
    }))
}

/// The errors of `estimator`.
fn of(scores: &[EstimatorScores], estimator: Estimator) -> Option<&DesignScores> {
    scores.iter().find(|s| s.estimator == estimator)?.designs.iter().find(|d| d.design == DESIGN)
}
