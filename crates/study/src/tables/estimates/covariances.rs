//! The table of covariances: a row per row of the table of estimates.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use estimation::{EstimateCovariance, Estimator, RunEstimate};
use files::{Columns, Error, Provenance, Staged, TableReader, TableWriter};
use ship::model::Vessel;

/// Schema id of covariances.
pub const ID: &str = "covariances";
/// Version of the schema.
pub const VERSION: u32 = 1;
/// The usual name of the table.
pub const FILE: &str = "covariances.parquet";

/// The covariance of the estimate of one run by one estimator.
#[derive(Clone, Debug, PartialEq)]
pub struct CovarianceRow {
    /// The run's design.
    pub design: String,
    /// The run's number.
    pub run: i32,
    /// The estimator.
    pub estimator: Estimator,
    /// Its covariance.
    pub covariance: EstimateCovariance,
}

impl CovarianceRow {
    /// That of `estimate`.
    pub fn of(estimate: &RunEstimate, covariance: EstimateCovariance) -> Self {
        let finite = |entries: &Vec<f64>| entries.iter().all(|entry| entry.is_finite());
        Self {
            design: estimate.design.clone(),
            run: estimate.run,
            estimator: estimate.estimator,
            covariance: covariance.filter(finite),
        }
    }
}

/// Bytes of memory of a row.
pub fn row_bytes(vessel: &Vessel) -> f64 {
    (size_of::<CovarianceRow>() + size_of::<f64>() * vessel.model.parameters().pow(2) + 32) as f64
}

/// The columns for `vessel`: those that say which estimate it is, then every pair of parameters, the first no later than
/// the second, in the order of the model. Other pairs are their mirror images.
pub fn columns(vessel: &Vessel) -> Columns<CovarianceRow> {
    let mut columns = Columns::<CovarianceRow>::new(ID, VERSION)
        .text("design", |r| &r.design, |r, design| r.design = design.to_owned())
        .integer("run", "1", |r| r.run, |r, run| r.run = run)
        .choice("estimator", |r| r.estimator, |r, estimator| r.estimator = estimator);
    let parameters = || vessel.model.parameter_names().zip(vessel.model.parameter_units());
    let all = vessel.model.parameters();
    for (i, (first, first_unit)) in parameters().enumerate() {
        for (j, (second, second_unit)) in parameters().enumerate().skip(i) {
            columns = columns.optional(
                format!("{first} {second}"),
                &format!("({first_unit}) × ({second_unit})"),
                move |r| r.covariance.as_ref().map(|covariance| covariance[i * all + j]),
                move |r, value| {
                    if let Some(value) = value {
                        let get_or_insert_with = r.covariance.get_or_insert_with(|| vec![0.0; all * all]);
                        get_or_insert_with[i * all + j] = value;
                        get_or_insert_with[j * all + i] = value;
                    }
                },
            );
        }
    }
    columns
}

/// Reads block `i` of `reader`.
///
/// # Errors
/// Missing columns; damaged blocks.
pub fn rows(reader: &TableReader, vessel: &Vessel, i: usize) -> Result<Vec<CovarianceRow>, Error> {
    let blank = CovarianceRow { design: String::new(), run: 0, estimator: Estimator::Iv, covariance: None };
    columns(vessel).read_block(reader, i, &blank)
}

/// Rows of a block of the table.
const BLOCK: usize = 1 << 14;

/// Covariances that are kept while blocks of runs are estimated in any order.
pub struct Covariances {
    path: PathBuf,
    kept: Mutex<BTreeMap<usize, Vec<CovarianceRow>>>,
}

impl Covariances {
    /// None yet, for the table at `path`.
    pub fn new(path: &Path) -> Self {
        Self { path: path.to_owned(), kept: Mutex::default() }
    }

    /// Keeps the covariances of block `i`, and returns its estimates.
    pub fn keep(&self, i: usize, found: Vec<(RunEstimate, EstimateCovariance)>) -> Vec<RunEstimate> {
        let split = found.into_iter().map(|(estimate, c)| (CovarianceRow::of(&estimate, c), estimate));
        let (rows, estimates) = split.unzip();
        self.kept.lock().unwrap_or_else(PoisonError::into_inner).insert(i, rows);
        estimates
    }

    /// The table, in the order of blocks; `document` vouches for it.
    ///
    /// # Errors
    /// Output that fails.
    pub fn staged(self, vessel: &Vessel, document: &Path, provenance: &Provenance) -> Result<Staged, Error> {
        let columns = columns(vessel);
        let kept = self.kept.into_inner().unwrap_or_else(PoisonError::into_inner);
        let rows: Vec<CovarianceRow> = kept.into_values().flatten().collect();
        let mut writer =
            TableWriter::create(&self.path, columns.schema(), provenance)?.with_document(document);
        for rows in rows.chunks(BLOCK) {
            writer.push(columns.encode(rows)?)?;
        }
        writer.finish()
    }
}
