use artifact::{Column, ColumnSpec, Kind, Table, TableSchema};

use super::Arm;
use crate::estimates::{labels, optional};

/// Schema id.
pub const ID: &str = "sequential";
/// Version of the schema.
pub const VERSION: u32 = 1;

/// One row: an arm of a realization at the end of a round.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// How the sea time was spent.
    pub arm: Arm,
    /// Number of the realization.
    pub realization: u32,
    /// Round, from 0.
    pub round: u32,
    /// Samples sailed so far.
    pub samples: usize,
    /// Whether the design could be made; else all maneuvers shared the time.
    pub designed: bool,
    /// 2-norm over the parameters of (estimate − truth)/truth; `None` without an estimate.
    pub parameter_error: Option<f64>,
    /// 2-norm over the parameters of standard error over estimate.
    pub predicted_error: Option<f64>,
}

/// The columns.
pub fn schema() -> TableSchema {
    let columns = vec![
        ColumnSpec::new("arm", "1", Kind::Text, false),
        ColumnSpec::new("realization", "1", Kind::I32, false),
        ColumnSpec::new("round", "1", Kind::I32, false),
        ColumnSpec::new("time", "s", Kind::F64, false),
        ColumnSpec::new("status", "1", Kind::Text, false),
        ColumnSpec::new("parameter_error", "1", Kind::F64, true),
        ColumnSpec::new("predicted_error", "1", Kind::F64, true),
    ];
    TableSchema { id: ID, version: VERSION, columns }
}

/// Rows as a block of the table.
pub fn table(rows: &[Row], rate_hz: f64) -> Table {
    let status = |row: &Row| match (row.parameter_error, row.designed) {
        (None, _) => "not identifiable",
        (Some(_), true) => "identified",
        (Some(_), false) => "identified without a design",
    };
    Table {
        columns: vec![
            labels(rows.iter().map(|r| r.arm.name())),
            Column::i32(rows.iter().map(|r| r.realization as i32).collect()),
            Column::i32(rows.iter().map(|r| r.round as i32).collect()),
            Column::f64(rows.iter().map(|r| r.samples as f64 / rate_hz).collect()),
            labels(rows.iter().map(status)),
            optional(rows.iter().map(|r| r.parameter_error)),
            optional(rows.iter().map(|r| r.predicted_error)),
        ],
    }
}
