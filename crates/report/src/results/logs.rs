//! How well models predict measured recordings that were left out.

use std::path::PathBuf;

use artifact::{Error, Loaded};
use study::documents::{CrossvalDocument, EstimatorScore};

use super::folder::{documents, label, left_out};
use super::table::Table;
use crate::number::{exact, three_or_dash};

const HEADS: [&str; 7] =
    ["logs", "estimator", "fit of surge, sway, yaw rate", "error norm", "folds", "windows", "length"];

pub(super) fn section(folders: &[PathBuf]) -> Result<Option<String>, Error> {
    let (found, missing) = documents::<CrossvalDocument>(folders, "crossval.json")?;
    let mut table = Table::new(&HEADS);
    for (folder, Loaded { data: document, .. }) in &found {
        for score in &document.estimators {
            let length = document.window_s.map_or("whole".to_owned(), |s| format!("{} s", exact(s)));
            table.row(&[
                label(folder),
                format!("`{}`", score.name),
                fits(score),
                three_or_dash(score.error_norm),
                document.folds.to_string(),
                document.windows.to_string(),
                length,
            ]);
        }
    }
    let note = left_out(&missing, "the logs were not there; see own-logs.md");
    let about = "Each recording is left out in turn and predicted by the model of the others. Fit: 100 (1 − RMSE/std), 0 is as good as the mean \
        of the data, 100 perfect. Measured logs exist once, so there is nothing to repeat and no interval.";
    Ok((!folders.is_empty()).then(|| {
        let table = table.text().map_or(String::new(), |table| format!("\n{table}"));
        format!("## Measured logs\n\n{about}\n{table}{note}")
    }))
}

fn fits(score: &EstimatorScore) -> String {
    let fit = |fit: Option<f64>| fit.map_or("–".to_owned(), |fit| format!("{fit:.1}"));
    match &score.errors {
        Some(e) => format!("{} / {} / {} %", fit(e.fit_u), fit(e.fit_v), fit(e.fit_r)),
        None => score.status.to_string(),
    }
}
