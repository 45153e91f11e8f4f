//! How well models predict measured recordings that were left out.

use std::path::PathBuf;

use files::Error;
use study::documents::{CrossvalDocument, EstimatorScore};

use super::{Table, documents, label, left_out};
use crate::number::{exact, or_dash, three_or_dash, three_within};

pub(super) fn section(folders: &[PathBuf]) -> Result<Option<String>, Error> {
    let (found, missing) = documents::<CrossvalDocument>(folders, "crossval.json")?;
    let scores = found.iter().flat_map(|(folder, loaded)| {
        loaded.data.estimators.iter().map(move |score| (folder, &loaded.data, score))
    });
    let table = Table::of(scores)
        .column("logs", |(folder, ..)| label(folder))
        .column("estimator", |(.., score)| format!("`{}`", score.name))
        .column("fit of surge, sway, yaw rate", |(.., score)| fits(score))
        .column("error norm", |(.., score)| three_or_dash(score.error_norm))
        .column("above the least", |(_, document, score)| {
            or_dash(document.difference(score.name).map(|d| three_within(d.median, Some(d.interval))))
        })
        .column("folds", |(_, document, _)| document.folds.to_string())
        .column("windows", |(_, document, _)| document.windows.to_string())
        .column("length", |(_, document, _)| {
            document.window_s.map_or("whole".to_owned(), |s| format!("{} s", exact(s)))
        });
    let note = left_out(&missing, "the logs were not there; see own-logs.md");
    let about = "Each recording is left out in turn and predicted by the model of the others. Fit: 100 (1 − RMSE/std), 0 is as good as the mean \
        of the data, 100 perfect. Above the least: how far the error norm of a recording lies above that by the estimator of \
        least median norm, median over the recordings with its 95 % interval; one that contains 0 tells no difference.";
    Ok((!folders.is_empty()).then(|| {
        let table = table.text().map_or(String::new(), |table| format!("\n{table}"));
        format!("## Measured logs\n\n{about}\n{table}{note}")
    }))
}

fn fits(score: &EstimatorScore) -> String {
    let fit = |fit: Option<f64>| or_dash(fit.map(|fit| format!("{fit:.1}")));
    match &score.errors {
        Some(e) => format!("{} / {} / {} %", fit(e.fit_u), fit(e.fit_v), fit(e.fit_r)),
        None => score.status.to_string(),
    }
}
