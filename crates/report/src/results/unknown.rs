//! Estimators that find a current and noise that are not given.

use std::path::PathBuf;

use files::Error;
use serde_json::Value;
use study::documents::{EstimateDocument, ValidationDocument};

use super::{Table, documents, label, left_out, median};
use crate::loader::document_at;
use crate::number::{or_dash, percent};

/// Settings of estimates for unknowns, as flags of `estimate`.
const FLAGS: [(&str, &str); 2] = [("unknown_current", "--unknown-current"), ("intercepts", "--intercepts")];

pub(super) fn section(folders: &[PathBuf]) -> Result<Option<String>, Error> {
    let (found, missing) = documents::<ValidationDocument>(folders, "validation.json")?;
    let mut rows = Vec::new();
    for (folder, validation) in &found {
        let estimate = document_at::<EstimateDocument>(folder.join("estimate.json"))?;
        let settings = estimate.map(|own| own.provenance.settings).unwrap_or_default();
        let setting = |name: &str| settings.get(name).and_then(Value::as_str);
        let flags = FLAGS.iter().filter_map(|(name, flag)| Some(format!(" {flag} {}", setting(name)?)));
        let way = format!("`{}{}`", setting("estimator").unwrap_or("–"), flags.collect::<String>());
        let scenario = folder.ancestors().nth(2).map(label);
        rows.extend(
            validation
                .data
                .designs
                .iter()
                .map(|design| (scenario.clone(), way.clone(), validation.data.seed, design)),
        );
    }
    rows.retain(|(.., own)| own.design == super::estimators::DESIGN);
    let table = Table::of(rows)
        .column("scenario", |(scenario, ..)| or_dash(scenario.clone()))
        .column("trials", |(.., own)| own.runs.to_string())
        .column("seed", |(.., seed, _)| or_dash(*seed))
        .column("estimator", |(_, way, ..)| way.clone())
        .column("median parameter error", |(.., own)| median(&own.parameter_error))
        .column("without an estimate", |(.., own)| or_dash(own.without_estimate_share.map(percent)));
    let note = left_out(&missing, "not computed");
    Ok(table.text().map(|table| format!("## Current as an unknown\n\n{HEAD}\n\n{table}{note}")))
}

const HEAD: &str = "The same trials of the optimized design, estimated without being told of the disturbances (`estimate` without `--campaign`).";
