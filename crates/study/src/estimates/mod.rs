//! The table of estimates: one row per run.

mod summary;

use std::path::Path;

use artifact::{Column, ColumnSpec, Kind, Table, TableReader, TableSchema};
use vessel::{DegreeOfFreedom, Vessel};

use artifact::Error;

pub use summary::{distinct, estimators, summarize};

/// Schema id of estimates.
pub const ID: &str = "estimates";
/// Version of the schema.
pub const VERSION: u32 = 1;
/// `status` of a run with an estimate.
pub const IDENTIFIED: &str = "identified";
/// `status` of a run whose estimate could not be refined further.
pub const KEPT: &str = "kept";
/// `status` of a run without.
pub const NOT_IDENTIFIABLE: &str = "not identifiable";
/// `status` of a run whose search for an estimate ended nowhere.
pub const NOT_CONVERGED: &str = "not converged";

/// What became of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    /// It has an estimate.
    Identified,
    /// It has one that could not be refined further: a simulation with it diverged.
    Kept,
    /// A direction is not excited.
    NotIdentifiable,
    /// The search for an estimate ended nowhere.
    NotConverged,
}

impl Status {
    const ALL: [Self; 4] = [Self::Identified, Self::Kept, Self::NotIdentifiable, Self::NotConverged];

    /// As in files.
    pub fn name(self) -> &'static str {
        [IDENTIFIED, KEPT, NOT_IDENTIFIABLE, NOT_CONVERGED][self as usize]
    }

    /// Whether there is an estimate.
    fn estimated(self) -> bool {
        matches!(self, Self::Identified | Self::Kept)
    }
}

/// One row.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// Its design.
    pub design: String,
    /// Number of the run.
    pub run: i32,
    /// `iv`, `ls`, `refined-iv`, `output-error` …
    pub estimator: String,
    /// Whether there is an estimate, and if not why.
    pub status: Status,
    /// θ̂ and its standard errors, where there is one.
    pub estimate: Option<(Vec<f64>, Vec<f64>)>,
    /// Condition number per degree of freedom; infinite where a direction is not excited.
    pub condition: [f64; 3],
    /// Name of the parameter that dominates the weakest direction, per degree of freedom.
    pub weakest: [String; 3],
}

/// The columns for `vessel`.
pub fn schema(vessel: &Vessel) -> TableSchema {
    let mut columns = vec![
        ColumnSpec::new("design", "1", Kind::Text, false),
        ColumnSpec::new("run", "1", Kind::I32, false),
        ColumnSpec::new("estimator", "1", Kind::Text, false),
        ColumnSpec::new("status", "1", Kind::Text, false),
    ];
    for (name, unit) in vessel.model.parameter_names().zip(vessel.model.parameter_units()) {
        columns.push(ColumnSpec::new(name, &unit, Kind::F64, true));
        columns.push(ColumnSpec::new(format!("{name}_se"), &unit, Kind::F64, true));
    }
    for d in DegreeOfFreedom::ALL {
        columns.push(ColumnSpec::new(format!("condition_{}", d.name()), "1", Kind::F64, true));
        columns.push(ColumnSpec::new(format!("weakest_{}", d.name()), "1", Kind::Text, false));
    }
    TableSchema { id: ID, version: VERSION, columns }
}

/// Rows as a block of the table.
pub fn table(vessel: &Vessel, rows: &[Row]) -> Table {
    let mut columns = vec![
        labels(rows.iter().map(|r| r.design.as_str())),
        Column::i32(rows.iter().map(|r| r.run).collect()),
        labels(rows.iter().map(|r| r.estimator.as_str())),
        labels(rows.iter().map(|r| r.status.name())),
    ];
    for i in 0..vessel.model.parameters() {
        columns.push(optional(rows.iter().map(|r| r.estimate.as_ref().map(|(theta, _)| theta[i]))));
        columns.push(optional(rows.iter().map(|r| r.estimate.as_ref().map(|(_, se)| se[i]))));
    }
    for d in 0..3 {
        columns.push(optional(rows.iter().map(|r| Some(r.condition[d]).filter(|c| c.is_finite()))));
        columns.push(labels(rows.iter().map(|r| r.weakest[d].as_str())));
    }
    Table { columns }
}

/// A text column.
pub fn labels<'a>(values: impl Iterator<Item = &'a str>) -> Column {
    let mut known: Vec<String> = Vec::new();
    let mut code = |value: &str| match known.iter().position(|k| k == value) {
        Some(code) => code as u32,
        None => {
            known.push(value.to_owned());
            known.len() as u32 - 1
        }
    };
    let codes = values.map(&mut code).collect();
    Column::text(known, codes)
}

/// A column of values that may be absent.
pub fn optional(values: impl Iterator<Item = Option<f64>>) -> Column {
    let (values, present) = values.map(|v| (v.unwrap_or(0.0), v.is_some())).unzip();
    Column::nullable_f64(values, present)
}

/// Reads block `i` of `reader`.
///
/// # Errors
/// Damaged blocks.
pub fn rows(reader: &TableReader, vessel: &Vessel, file: &Path, i: usize) -> Result<Vec<Row>, Error> {
    let schema = schema(vessel);
    let names: Vec<&str> = schema.columns.iter().map(|c| c.name.as_str()).collect();
    let table = reader.read_block(i, &names)?;
    let parameters = vessel.model.parameters();
    let text = |column: usize, row: usize| table.columns[column].text_at(row).unwrap_or("").to_owned();
    let number = |column: usize, row: usize| table.columns[column].value_at(row);
    let row = |row: usize| {
        let (status, width) = (text(3, row), 4 + 2 * parameters);
        let status = Status::ALL.into_iter().find(|known| known.name() == status);
        let status = status.ok_or_else(|| refuse(file, row, &format!("status `{}`", text(3, row))))?;
        let every = |offset: usize| (0..parameters).map(|p| number(4 + 2 * p + offset, row)).collect();
        let complete: Option<(Vec<f64>, Vec<f64>)> = Option::zip(every(0), every(1));
        if status.estimated() && complete.is_none() {
            return Err(refuse(file, row, "an absent parameter"));
        }
        Ok(Row {
            design: text(0, row),
            run: table.columns[1].as_i32().map_or(0, |runs| runs[row]),
            estimator: text(2, row),
            status,
            estimate: complete.filter(|_| status.estimated()),
            condition: [0, 1, 2].map(|d| number(width + 2 * d, row).unwrap_or(f64::INFINITY)),
            weakest: [0, 1, 2].map(|d| text(width + 2 * d + 1, row)),
        })
    };
    (0..reader.block_rows(i)).map(row).collect()
}

fn refuse(file: &Path, row: usize, found: &str) -> Error {
    let expected =
        format!("`{IDENTIFIED}` or `{KEPT}` with all parameters, `{NOT_IDENTIFIABLE}` or `{NOT_CONVERGED}`");
    crate::refuse(file, &format!("row {row}"), found, &expected, "run `estimate` again")
}
