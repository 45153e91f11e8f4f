//! The table of estimates: one row per run.

pub mod covariances;
mod published;
mod summary;
mod unidentified;

use std::path::Path;

pub use estimation::RunEstimate as Row;
use estimation::{EstimateStatus, Estimator};
use files::{Columns, Error, TableReader};
pub use published::publish;
use refusal::listed;
use ship::model::Vessel;
pub use summary::{CRITICISED, criticised, distinct, estimators, summarize};
pub use unidentified::unidentified;

/// Schema id of estimates.
pub const ID: &str = "estimates";
/// Version of the schema.
pub const VERSION: u32 = 1;

/// Bytes of memory of a row in a growing list.
pub fn row_bytes(vessel: &Vessel) -> f64 {
    let heap = 16 * vessel.model.parameters() + 80;
    // A growing list is copied into one of twice its length.
    (3 * size_of::<Row>() + heap) as f64
}

/// The columns for `vessel`.
pub fn columns(vessel: &Vessel) -> Columns<Row> {
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
                move |r| r.estimate.as_ref().map(|(theta, _)| theta[i]),
                move |r, value| {
                    r.estimate.iter_mut().for_each(|(theta, _)| theta[i] = value.unwrap_or(f64::NAN));
                },
            )
            .optional(
                format!("{name}_se"),
                &unit,
                move |r| r.estimate.as_ref().map(|(_, se)| se[i]).filter(|se| !se.is_nan()),
                move |r, value| {
                    r.estimate.iter_mut().for_each(|(_, se)| se[i] = value.unwrap_or(f64::NAN));
                },
            );
    }
    for (d, name) in blocks(vessel).iter().copied().enumerate() {
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

/// What has a condition number of its own: each degree of freedom; the numbers of a ship with forces together.
pub(crate) fn blocks(vessel: &Vessel) -> &'static [&'static str] {
    if vessel.model.forces.is_some() { &["forces"] } else { &["surge", "sway", "yaw"] }
}

/// Whether the table `file` has all parameters of `vessel`.
///
/// # Errors
/// See [`TableReader::open`].
pub fn of_all(file: &Path, vessel: &Vessel) -> Result<bool, Error> {
    let table = TableReader::open(file, ID, VERSION)?;
    let there = |name: &str| table.columns().iter().any(|column| column.name == name);
    Ok(vessel.model.parameter_names().all(there))
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
        if !row.status.estimated() {
            row.estimate = None;
        }
        let Some((theta, se)) = &row.estimate else { continue };
        let waves = row.status == EstimateStatus::Waves;
        let se: &[f64] = if waves { &[] } else { se };
        if theta.iter().chain(se).any(|value| !value.is_finite()) {
            return Err(incomplete(file, number));
        }
        let no_estimate = theta.iter().find(|value| value.abs() > MOST);
        if let Some(value) = no_estimate.or(se.iter().find(|se| !is_error(**se))) {
            return Err(implausible(file, number, *value));
        }
    }
    Ok(rows)
}

/// Above it squares, and with them the statistics of a table, overflow.
const MOST: f64 = 1e150;

/// Refuses a row of `file` with `value`, which no stage writes.
pub(crate) fn implausible(file: &Path, row: usize, value: f64) -> Error {
    let expected = format!("magnitudes up to {MOST:e}, and errors from 0");
    crate::refuse(
        file,
        &format!("row {row}"),
        &format!("{value:e}"),
        &expected,
        "run the stage that writes it again",
    )
}

/// Whether an error or a score is valid.
pub(crate) fn is_error(value: f64) -> bool {
    (0.0..=MOST).contains(&value)
}

fn incomplete(file: &Path, row: usize) -> Error {
    let estimated = EstimateStatus::ALL.into_iter().filter(|own| own.estimated());
    let named: Vec<String> = estimated.map(|estimated| format!("`{estimated}`")).collect();
    let expected = format!("all parameters where the status is {}", listed(&named));
    crate::refuse(file, &format!("row {row}"), "an absent parameter", &expected, "run `estimate` again")
}
