//! Scores of models from picked sub-experiments; counts of the picks.

use std::collections::BTreeMap;

use estimation::ScoreStatus;
use files::{Columns, Error, TableReader};
use refusal::Invalid;
use ship::model::DegreeOfFreedom;
pub use validation::selection::Realization as Row;

use crate::documents::DesignDocument;
use crate::tables::scores;

/// Reads the whole table.
///
/// # Errors
/// Missing columns, damaged blocks.
pub fn rows(reader: &TableReader) -> Result<Vec<Row>, Error> {
    let blank = Row {
        design: String::new(),
        number: 0,
        picked: String::new(),
        status: ScoreStatus::NotIdentifiable,
        rmse: Some([0.0; 3]),
        error_norm: None,
        left_out_rmse: Some([0.0; 3]),
        left_out_norm: None,
    };
    columns().read(reader, &blank)
}

/// The columns.
pub fn columns() -> Columns<Row> {
    let columns = scores::of::<Row>()
        .text("design", |r| &r.design, |r, design| r.design = design.to_owned())
        .integer("run", "1", |r| r.number, |r, number| r.number = number)
        .text("pick", |r| &r.picked, |r, picked| r.picked = picked.to_owned())
        .choice("status", |r| r.status, |r, status| r.status = status);
    let columns = errors(columns, "", |r| r.rmse, |r| &mut r.rmse).optional(
        "error_norm",
        "1",
        |r| r.error_norm,
        |r, norm| r.error_norm = norm,
    );
    errors(columns, "left_out_", |r| r.left_out_rmse, |r| &mut r.left_out_rmse).optional(
        "left_out_error_norm",
        "1",
        |r| r.left_out_norm,
        |r, norm| r.left_out_norm = norm,
    )
}

/// Adds a column per state; a row has all three errors or none.
fn errors(
    columns: Columns<Row>,
    prefix: &str,
    get: fn(&Row) -> Option<[f64; 3]>,
    of: fn(&mut Row) -> &mut Option<[f64; 3]>,
) -> Columns<Row> {
    DegreeOfFreedom::ALL.into_iter().fold(columns, |columns, degree| {
        let d = degree as usize;
        let set = move |r: &mut Row, value: Option<f64>| {
            let errors = of(r);
            *errors = errors.zip(value).map(|(mut errors, value)| {
                errors[d] = value;
                errors
            });
        };
        let name = format!("{prefix}rmse_{}", degree.state());
        columns.optional(name, degree.unit(), move |r| get(r).map(|errors| errors[d]), set)
    })
}

/// The counts of `design`, no more than available.
///
/// # Errors
/// A design without counts; more than available.
pub fn counts_of(
    design: &DesignDocument,
    available: &BTreeMap<String, u64>,
) -> Result<BTreeMap<String, u64>, Invalid> {
    let Some(counts) = &design.counts else {
        let remedy = "make it with `design --segments`";
        return Err(Invalid::new("counts", "none", "those of whole segments", remedy));
    };
    let counts: BTreeMap<String, u64> =
        counts.iter().filter(|(_, count)| **count > 0).map(|(name, count)| (name.clone(), *count)).collect();
    let there = |name: &str| available.get(name).copied().unwrap_or(0);
    match counts.iter().find(|(name, count)| **count > there(name)) {
        None => Ok(counts),
        Some((name, count)) => Err(Invalid::new(
            "counts",
            format!("{count} of `{name}`"),
            format!("at most {}", there(name)),
            "bound the design by what there is: `design --available`",
        )),
    }
}
