//! The table of scores: one row per run.

use artifact::{Column, ColumnSpec, Kind, Table, TableReader, TableSchema};

use crate::documents::{Bounds, DesignScores, EstimatorScores, Quantiles};
use crate::estimates::{NOT_CONVERGED, NOT_IDENTIFIABLE, distinct, labels, optional};
use artifact::Error;

/// Schema id of scores.
pub const ID: &str = "scores";
/// Version of the schema.
pub const VERSION: u32 = 1;
/// `status` of a run whose model was simulated.
pub const SCORED: &str = "scored";
/// `status` of a run whose model diverged in free simulation.
pub const DIVERGED: &str = "diverged";

/// One row.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// Its design.
    pub design: String,
    /// Number of the run.
    pub run: i32,
    /// Its estimator.
    pub estimator: String,
    /// [`SCORED`], [`DIVERGED`], [`NOT_IDENTIFIABLE`] or [`NOT_CONVERGED`].
    pub status: String,
    /// ‖(θ̂ − θ)/θ‖, where the run is identified and the truth known.
    pub parameter_error: Option<f64>,
    /// RMSE in u, v \[m/s\] and r \[rad/s\], where the simulation did not diverge.
    pub rmse: [Option<f64>; 3],
    /// Their norm.
    pub simulation_error: Option<f64>,
}

/// The columns.
pub fn schema() -> TableSchema {
    TableSchema {
        id: ID,
        version: VERSION,
        columns: vec![
            ColumnSpec::new("design", "1", Kind::Text, false),
            ColumnSpec::new("run", "1", Kind::I32, false),
            ColumnSpec::new("estimator", "1", Kind::Text, false),
            ColumnSpec::new("status", "1", Kind::Text, false),
            ColumnSpec::new("parameter_error", "1", Kind::F64, true),
            ColumnSpec::new("rmse_u", "m/s", Kind::F64, true),
            ColumnSpec::new("rmse_v", "m/s", Kind::F64, true),
            ColumnSpec::new("rmse_r", "rad/s", Kind::F64, true),
            ColumnSpec::new("simulation_error", "m/s, m/s and rad/s as numbers", Kind::F64, true),
        ],
    }
}

/// Rows as a block of the table.
pub fn table(rows: &[Row]) -> Table {
    let mut columns = vec![
        labels(rows.iter().map(|r| r.design.as_str())),
        Column::i32(rows.iter().map(|r| r.run).collect()),
        labels(rows.iter().map(|r| r.estimator.as_str())),
        labels(rows.iter().map(|r| r.status.as_str())),
        optional(rows.iter().map(|r| r.parameter_error)),
    ];
    columns.extend((0..3).map(|d| optional(rows.iter().map(|r| r.rmse[d]))));
    columns.push(optional(rows.iter().map(|r| r.simulation_error)));
    Table { columns }
}

/// Reads the whole table.
///
/// # Errors
/// Missing columns, damaged blocks.
pub fn rows(reader: &TableReader) -> Result<Vec<Row>, Error> {
    let schema = schema();
    reader.require(&schema.columns)?;
    let names: Vec<&str> = schema.columns.iter().map(|c| c.name.as_str()).collect();
    let mut rows = Vec::with_capacity(reader.rows());
    for block in 0..reader.blocks() {
        let table = reader.read_block(block, &names)?;
        let text = |column: usize, row: usize| table.columns[column].text_at(row).unwrap_or("").to_owned();
        let number = |column: usize, row: usize| table.columns[column].value_at(row);
        rows.extend((0..reader.block_rows(block)).map(|row| Row {
            design: text(0, row),
            run: table.columns[1].as_i32().map_or(0, |runs| runs[row]),
            estimator: text(2, row),
            status: text(3, row),
            parameter_error: number(4, row),
            rmse: [5, 6, 7].map(|column| number(column, row)),
            simulation_error: number(8, row),
        }));
    }
    Ok(rows)
}

/// The estimators of `rows`, in their order.
pub fn estimators(rows: &[Row]) -> Vec<&str> {
    distinct(rows.iter().map(|row| row.estimator.as_str()))
}

/// The estimator that stands for a study: the only one, or `iv` where several are compared.
pub fn leading(rows: &[Row]) -> &str {
    let names = estimators(rows);
    names.iter().find(|name| **name == "iv").or(names.first()).copied().unwrap_or("")
}

/// What the scores of each design say together, in the order of the rows, by the [`leading`] estimator.
pub fn summarize(rows: &[Row], bounds: Bounds) -> Vec<DesignScores> {
    by_estimator(rows, leading(rows), bounds)
}

/// The same for every estimator, where there are several.
pub fn compare(rows: &[Row], bounds: Bounds) -> Option<Vec<EstimatorScores>> {
    let names = estimators(rows);
    let of = |name: &&str| EstimatorScores {
        estimator: (*name).to_owned(),
        designs: by_estimator(rows, name, bounds),
    };
    (names.len() > 1).then(|| names.iter().map(of).collect())
}

fn by_estimator(rows: &[Row], estimator: &str, bounds: Bounds) -> Vec<DesignScores> {
    let mut designs: Vec<&str> = rows.iter().map(|r| r.design.as_str()).collect();
    designs.dedup();
    designs.iter().map(|design| design_scores(design, estimator, rows, bounds)).collect()
}

fn design_scores(design: &str, estimator: &str, rows: &[Row], bounds: Bounds) -> DesignScores {
    let own = || rows.iter().filter(|r| r.design == design && r.estimator == estimator);
    let runs = own().count();
    let with = |status: &str| own().filter(|r| r.status == status).count() as u64;
    let below = |value: fn(&Row) -> Option<f64>, bound: f64| {
        own().filter(|r| value(r).is_some_and(|v| v < bound)).count() as f64 / runs.max(1) as f64
    };
    DesignScores {
        design: design.to_owned(),
        runs: runs as u64,
        not_identifiable: with(NOT_IDENTIFIABLE),
        not_converged: Some(with(NOT_CONVERGED)).filter(|_| estimator.ends_with("-error")),
        diverged: with(DIVERGED),
        parameter_error_share: below(|r| r.parameter_error, bounds.parameter_error),
        simulation_error_share: below(|r| r.simulation_error, bounds.simulation_error),
        parameter_error: Quantiles::of(own().map(|r| r.parameter_error)),
        simulation_error: Quantiles::of(own().map(|r| r.simulation_error)),
        rmse_u: Quantiles::of(own().map(|r| r.rmse[0])),
        rmse_v: Quantiles::of(own().map(|r| r.rmse[1])),
        rmse_r: Quantiles::of(own().map(|r| r.rmse[2])),
    }
}
