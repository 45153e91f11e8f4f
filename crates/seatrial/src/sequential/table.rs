use artifact::{Column, ColumnSpec, Kind, Table, TableSchema};

use super::Arm;
use identification::EstimateStatus as Status;
use study::estimates::{labels, optional};

/// Schema id.
pub const ID: &str = "sequential";
/// Version of the schema.
pub const VERSION: u32 = 1;

/// How the time of a plan was shared out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shared {
    /// By a design.
    Designed,
    /// Evenly: no design could be made with the model.
    Even,
    /// At random, as asked for.
    Drawn,
}

/// What became of an estimate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// There is one.
    Identified,
    /// A direction is not excited.
    NotIdentifiable,
    /// The search ended nowhere.
    NotConverged,
    /// The nominal model diverges, with which the search begins.
    Diverged,
}

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
    /// How the round's time was shared out.
    pub shared: Shared,
    /// What became of the estimate.
    pub outcome: Outcome,
    /// 2-norm over the parameters of (estimate − truth)/truth; `None` without an estimate.
    pub parameter_error: Option<f64>,
    /// What the estimate says of its own error: 2-norm of standard error over the parameter known by then.
    pub predicted_error: Option<f64>,
    /// What the crude model says of a one-shot trial before it sails; `None` for others and where that model diverges.
    pub expected_error: Option<f64>,
}

impl Shared {
    fn name(self) -> &'static str {
        ["designed", "even", "drawn"][self as usize]
    }
}

impl Outcome {
    fn name(self) -> &'static str {
        ["identified", "not identifiable", "not converged", "diverged"][self as usize]
    }
}

impl From<Status> for Outcome {
    fn from(status: Status) -> Self {
        match status {
            Status::Identified | Status::Kept => Self::Identified,
            Status::NotIdentifiable => Self::NotIdentifiable,
            Status::NotConverged => Self::NotConverged,
        }
    }
}

/// The columns.
pub fn schema() -> TableSchema {
    let columns = vec![
        ColumnSpec::new("arm", "1", Kind::Text, false),
        ColumnSpec::new("realization", "1", Kind::I32, false),
        ColumnSpec::new("round", "1", Kind::I32, false),
        ColumnSpec::new("time", "s", Kind::F64, false),
        ColumnSpec::new("shares", "1", Kind::Text, false),
        ColumnSpec::new("status", "1", Kind::Text, false),
        ColumnSpec::new("parameter_error", "1", Kind::F64, true),
        ColumnSpec::new("predicted_error", "1", Kind::F64, true),
        ColumnSpec::new("expected_error", "1", Kind::F64, true),
    ];
    TableSchema { id: ID, version: VERSION, columns }
}

/// Rows as a block of the table.
pub(super) fn table(rows: &[Row], rate_hz: f64) -> Table {
    Table {
        columns: vec![
            labels(rows.iter().map(|r| r.arm.name())),
            Column::i32(rows.iter().map(|r| r.realization as i32).collect()),
            Column::i32(rows.iter().map(|r| r.round as i32).collect()),
            Column::f64(rows.iter().map(|r| r.samples as f64 / rate_hz).collect()),
            labels(rows.iter().map(|r| r.shared.name())),
            labels(rows.iter().map(|r| r.outcome.name())),
            optional(rows.iter().map(|r| r.parameter_error)),
            optional(rows.iter().map(|r| r.predicted_error)),
            optional(rows.iter().map(|r| r.expected_error)),
        ],
    }
}
