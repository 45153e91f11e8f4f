//! Every estimator under several kinds of disturbance.

use std::path::PathBuf;

use files::Error;
use study::documents::{DesignScores, Estimator, EstimatorScores, ValidationDocument};

use super::{Table, documents, label, left_out, median, seed};
use crate::number::or_dash;

/// The design whose errors are in the table.
pub(super) const DESIGN: &str = "optimized";

pub(super) fn section(folders: &[PathBuf]) -> Result<Option<String>, Error> {
    let (found, missing) = documents::<ValidationDocument>(folders, "validation.json")?;
    let compared: Vec<&[EstimatorScores]> =
        found.iter().map(|(_, v)| v.data.compared.as_deref().unwrap_or_default()).collect();
    let given = |estimator: &Estimator| compared.iter().any(|scores| of(scores, *estimator).is_some());
    let estimators: Vec<Estimator> = Estimator::OF_RUNS.into_iter().filter(given).collect();
    let mut rows = Vec::new();
    for ((folder, _), scores) in found.iter().zip(&compared) {
        let own: Vec<Option<&DesignScores>> =
            estimators.iter().map(|estimator| of(scores, *estimator)).collect();
        rows.push((label(folder), seed(folder)?, own));
    }
    let table = Table::of(rows)
        .column("scenario", |(name, ..)| name.clone())
        .column("trials", |(.., own)| or_dash(own.iter().flatten().next().map(|d| d.runs)))
        .column("seed", |(_, seed, _)| or_dash(*seed));
    let table = estimators.iter().enumerate().fold(table, |table, (i, estimator)| {
        let error = |own: &[Option<&DesignScores>]| or_dash(own[i].map(|d| median(&d.parameter_error)));
        table.column(&format!("`{estimator}`"), |(.., own)| error(own))
    });
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
