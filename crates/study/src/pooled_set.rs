//! The set of files of a pooled estimate.

use std::path::Path;

use estimation::pooled::{Pool, Pooled};
use estimation::{Estimator, RunEstimate};
use files::{Error, Provenance, TableWriter, commit, stage_document, stage_set_document};
use regression::pooled::NominalSource;
use serde_json::{Value, json};
use ship::model::Vessel;

use crate::documents::{EstimateDocument, ModelDocument, Trust};
use crate::tables::estimates;

/// The usual name of the table.
pub const MAIN: &str = "estimates.parquet";

/// A row of estimates.parquet, estimate.json and model.json.
pub struct PooledSet {
    /// The vessel.
    pub vessel: Vessel,
    /// The estimate as that of one run.
    pub row: RunEstimate,
    /// Its summary, without what it can be trusted for.
    pub estimate: EstimateDocument,
    /// How far it can be trusted.
    pub trust: Trust,
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
        found: &Pooled,
    ) -> Self {
        Self {
            vessel: pool.vessel.clone(),
            row: found.as_run(estimator),
            estimate: EstimateDocument::pooled(pool.vessel, estimator, pool.removal, found),
            trust: Trust::new(pool, nominal, (estimator, replicates), found),
            model: ModelDocument::new(pool, estimator, found),
            turned: found.turned.clone(),
        }
    }

    /// Writes the set: the table, its `summary` with what is to be said there besides, and the model.
    ///
    /// # Errors
    /// Output that fails.
    pub fn write(
        &self,
        [table, summary, model]: [&Path; 3],
        provenance: &Provenance,
        said: EstimateDocument,
    ) -> Result<(), Error> {
        let columns = estimates::columns(&self.vessel);
        let mut writer = TableWriter::create(table, columns.schema(), provenance)?.with_document(summary);
        writer.push(columns.encode(std::slice::from_ref(&self.row))?)?;
        let mut staged = vec![writer.finish()?];
        if let Some(delivered) = &self.model {
            staged.push(stage_document(model, provenance, delivered)?);
        }
        staged.push(stage_set_document(summary, provenance, &said, &staged)?);
        commit(staged)
    }

    /// What estimate.json says, without what is found besides.
    pub fn document(&self) -> EstimateDocument {
        EstimateDocument { trust: Some(self.trust.clone()), ..self.estimate.clone() }
    }

    /// The summary in a line, and as JSON.
    pub fn summary(&self) -> (String, Value) {
        let Trust { estimator, parts, sources, samples, statements, .. } = &self.trust;
        let refused: Vec<&str> = self.trust.degrees.iter().filter_map(|d| d.reason.as_deref()).collect();
        let rest = match refused.as_slice() {
            [] => String::new(),
            reasons => format!("; not identifiable: {}", reasons.join("; ")),
        };
        let turned = self.turned.as_ref().map_or(String::new(), |turned| format!("; {turned}"));
        (
            format!("{estimator} from {parts} parts of {sources} runs, {samples} samples{rest}{turned}"),
            json!({"parts": parts, "sources": sources, "samples": samples,
                "not_identifiable": refused, "statements": statements}),
        )
    }
}
