//! The set of files of a pooled estimate.

use std::path::Path;

use estimation::pooled::{Added, Pool, Pooled};
use estimation::{Estimator, RunEstimate};
use files::{Error, Provenance, TableWriter, commit, stage_document, stage_set_document};
use regression::pooled::NominalSource;
use serde_json::{Value, json};
use ship::model::Vessel;

use crate::beside;
use crate::documents::{EstimateDocument, ModelDocument, TrustDocument};
use crate::tables::estimates;

/// The usual name of the table.
pub const MAIN: &str = "estimates.parquet";

/// A row of estimates.parquet, estimate.json, trust.json and model.json.
pub struct PooledSet {
    /// The vessel, with the terms that were added.
    pub vessel: Vessel,
    /// The estimate as that of one run.
    pub row: RunEstimate,
    /// Its summary.
    pub estimate: EstimateDocument,
    /// The diagnostics of the estimate.
    pub trust: TrustDocument,
    /// The model; `None` unless all degrees of freedom have an estimate.
    pub model: Option<ModelDocument>,
    /// The statement about estimates with another sign than the nominal value.
    turned: Option<String>,
}

impl PooledSet {
    /// The result of `estimator` from `pool` with instruments from `nominal`, with its number of resamples.
    pub fn new(
        pool: &Pool,
        nominal: NominalSource,
        (estimator, replicates): (Estimator, u32),
        (found, added): (&Pooled, &[Added]),
    ) -> Self {
        Self {
            vessel: pool.vessel.clone(),
            row: found.as_run(estimator),
            estimate: EstimateDocument::pooled(pool.vessel, estimator, pool.removal, found),
            trust: TrustDocument::new(pool, nominal, estimator, replicates, found, added),
            model: ModelDocument::new(pool, estimator, found),
            turned: found.turned.clone(),
        }
    }

    /// Writes the set whose main file is `out` and whose model is `path`.
    ///
    /// # Errors
    /// Output that fails.
    pub fn write(&self, [out, path]: [&Path; 2], provenance: &Provenance) -> Result<(), Error> {
        let columns = estimates::columns(&self.vessel);
        let name = |name| beside(out, MAIN, name);
        let summary = name("estimate.json");
        let mut writer = TableWriter::create(out, columns.schema(), provenance)?.with_document(&summary);
        writer.push(columns.encode(std::slice::from_ref(&self.row))?)?;
        let mut staged = vec![writer.finish()?, stage_document(name("trust.json"), provenance, &self.trust)?];
        if let Some(model) = &self.model {
            staged.push(stage_document(path, provenance, model)?);
        }
        staged.push(stage_set_document(&summary, provenance, &self.estimate, &staged)?);
        commit(staged)
    }

    /// The summary in a line, and as JSON.
    pub fn summary(&self) -> (String, Value) {
        let TrustDocument { estimator, parts, sources, samples, statements, .. } = &self.trust;
        let refused: Vec<&str> = self.trust.degrees.iter().filter_map(|d| d.reason.as_deref()).collect();
        let rest = match refused.as_slice() {
            [] => String::new(),
            reasons => format!("; not identifiable: {}", reasons.join("; ")),
        };
        let added: Vec<String> =
            self.trust.added.iter().map(|a| format!("`{}` in {}", a.term, a.degree)).collect();
        let more = if added.is_empty() { String::new() } else { format!("; added: {}", added.join(", ")) };
        let turned = self.turned.as_ref().map_or(String::new(), |turned| format!("; {turned}"));
        (
            format!(
                "{estimator} from {parts} parts of {sources} runs, {samples} samples{more}{rest}{turned}"
            ),
            json!({"parts": parts, "sources": sources, "samples": samples,
                "not_identifiable": refused, "added": added, "statements": statements}),
        )
    }
}
