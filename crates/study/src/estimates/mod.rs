//! The table of estimates: one row per run.

mod summary;

use std::path::Path;

use artifact::{Column, Columns, Error, Table, TableReader, TableSchema};
use identification::{EstimateStatus, Estimator};
use vessel::{DegreeOfFreedom, Vessel};

pub use summary::{distinct, estimators, summarize};

/// Schema id of estimates.
pub const ID: &str = "estimates";
/// Version of the schema.
pub const VERSION: u32 = 1;
/// One row.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// Its design.
    pub design: String,
    /// Number of the run.
    pub run: i32,
    /// Its estimator.
    pub estimator: Estimator,
    /// Whether there is an estimate, and if not why.
    pub status: EstimateStatus,
    /// θ̂ and its standard errors, where there is one.
    pub estimate: Option<(Vec<f64>, Vec<f64>)>,
    /// Condition number per degree of freedom; infinite where a direction is not excited.
    pub condition: [f64; 3],
    /// Name of the parameter that dominates the weakest direction, per degree of freedom.
    pub weakest: [String; 3],
}

/// The columns for `vessel`.
pub fn schema(vessel: &Vessel) -> TableSchema {
    columns(vessel).schema().clone()
}

/// Rows as a block of the table.
pub fn table(vessel: &Vessel, rows: &[Row]) -> Table {
    columns(vessel).table(rows)
}

fn columns(vessel: &Vessel) -> Columns<Row> {
    let mut columns = Columns::<Row>::new(ID, VERSION)
        .text("design", |r| &r.design, |r, design| r.design = design.to_owned())
        .integer("run", "1", |r| r.run, |r, run| r.run = run)
        .choice("estimator", |r| r.estimator, |r, estimator| r.estimator = estimator)
        .choice("status", |r| r.status, |r, status| r.status = status);
    let parameters = vessel.model.parameter_names().zip(vessel.model.parameter_units());
    for (i, (name, unit)) in parameters.enumerate() {
        columns = columns
            .optional(
                name,
                &unit,
                move |r| theta(r, i),
                move |r, value| {
                    r.estimate.iter_mut().for_each(|(theta, _)| theta[i] = value.unwrap_or(f64::NAN));
                },
            )
            .optional(
                format!("{name}_se"),
                &unit,
                move |r| error(r, i),
                move |r, value| {
                    r.estimate.iter_mut().for_each(|(_, se)| se[i] = value.unwrap_or(f64::NAN));
                },
            );
    }
    for degree in DegreeOfFreedom::ALL {
        let (name, d) = (degree.name(), degree as usize);
        let finite = move |r: &Row| Some(r.condition[d]).filter(|c| c.is_finite());
        columns = columns
            .optional(format!("condition_{name}"), "1", finite, move |r, condition| {
                r.condition[d] = condition.unwrap_or(f64::INFINITY);
            })
            .text(
                format!("weakest_{name}"),
                move |r| &r.weakest[d],
                move |r, weakest| {
                    r.weakest[d] = weakest.to_owned();
                },
            );
    }
    columns
}

fn theta(row: &Row, i: usize) -> Option<f64> {
    row.estimate.as_ref().map(|(theta, _)| theta[i])
}

fn error(row: &Row, i: usize) -> Option<f64> {
    row.estimate.as_ref().map(|(_, se)| se[i])
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
/// Damaged blocks; an estimate that lacks a parameter.
pub fn rows(reader: &TableReader, vessel: &Vessel, file: &Path, i: usize) -> Result<Vec<Row>, Error> {
    let absent = vec![f64::NAN; vessel.model.parameters()];
    let blank = Row {
        design: String::new(),
        run: 0,
        estimator: Estimator::Iv,
        status: EstimateStatus::NotIdentifiable,
        estimate: Some((absent.clone(), absent)),
        condition: [f64::INFINITY; 3],
        weakest: [const { String::new() }; 3],
    };
    let mut rows = columns(vessel).read_block(reader, i, &blank)?;
    for (number, row) in rows.iter_mut().enumerate() {
        let whole =
            |(theta, se): &(Vec<f64>, Vec<f64>)| theta.iter().chain(se).all(|value| value.is_finite());
        if !row.status.estimated() {
            row.estimate = None;
        } else if !row.estimate.as_ref().is_some_and(whole) {
            return Err(incomplete(file, number));
        }
    }
    Ok(rows)
}

fn incomplete(file: &Path, row: usize) -> Error {
    let expected = format!(
        "all parameters where the status is `{}` or `{}`",
        EstimateStatus::Identified,
        EstimateStatus::Kept
    );
    crate::refuse(file, &format!("row {row}"), "an absent parameter", &expected, "run `estimate` again")
}
