//! The table of realizations of a selection study; counts of its picks.

use std::collections::BTreeMap;

use estimation::ScoreStatus;
use estimation::pooled::Pool;
use files::{Columns, Error, TableReader};
use refusal::{Invalid, names_in, nearest};
use regression::pooled::NominalSource;
use ship::model::DegreeOfFreedom;
pub use validation::selection::Realization as Row;
use validation::selection::{DEGENERATE, Selection, SelectionOptions};

use crate::documents::{DesignDocument, SelectionDocument};

/// Schema id of the realizations of a selection study.
pub const ID: &str = "selection-realizations";
/// Version of the schema.
pub const VERSION: u32 = 1;

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
    let columns = Columns::<Row>::new(ID, VERSION)
        .text("design", |r| &r.design, |r, design| r.design = design.to_owned())
        .integer("realization", "1", |r| r.number, |r, number| r.number = number)
        .text("picked", |r| &r.picked, |r, picked| r.picked = picked.to_owned())
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

/// The document of `found`, with instruments from `nominal`.
pub fn document(
    pool: &Pool,
    nominal: NominalSource,
    options: &SelectionOptions,
    found: &Selection,
) -> SelectionDocument {
    let [std_u, std_v, std_r] = found.std;
    SelectionDocument {
        estimator: options.estimator,
        mean_removal: pool.removal,
        nominal,
        prior: pool.strength,
        intercepts: true,
        picks: found.picks,
        seed: Some(options.seed),
        counts: options.counts.clone(),
        available: found.available.clone(),
        parts: found.parts as u64,
        samples: found.samples,
        std_u,
        std_v,
        std_r,
        degenerate_from: DEGENERATE,
        published_limits: options.published_limits,
        ratio_q90: found.ratio_q90,
        statements: found.statements.clone(),
        instrument_fit: found.instrument_fit,
        designs: found.designs.to_vec(),
    }
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
        let remedy = "make it with `design --segments`, or name --counts";
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
            "bound the design by what there is, or name --counts",
        )),
    }
}

/// The number of sub-experiments of each maneuver to pick, as `label=n`, at most those that are `available`.
///
/// # Errors
/// In words: an invalid count, or one of an unknown maneuver.
pub fn counts(
    written: &[String],
    available: &BTreeMap<String, u64>,
) -> Result<BTreeMap<String, u64>, String> {
    let mut counts = BTreeMap::new();
    let is_count = |text: &str| text.split_once('=').is_some_and(|(_, c)| c.trim().parse::<u64>().is_ok());
    for text in written.iter().flat_map(|text| names_in(text, is_count)) {
        let pair =
            text.rsplit_once('=').and_then(|(name, n)| Some((name.trim(), n.trim().parse::<u64>().ok()?)));
        let Some((name, count)) = pair else {
            return Err(format!("--counts: found `{text}`, expected name=number; correct it"));
        };
        let Some(there) = available.get(name) else {
            let near = nearest(name, available.keys().map(String::as_str)).unwrap_or_default();
            return Err(format!(
                "--counts: found maneuver `{name}`, expected one of the trajectories'; did you mean `{near}`?"
            ));
        };
        if count > *there {
            return Err(format!("--counts: found {count} of `{name}`, expected at most {there}; lower it"));
        }
        *counts.entry(name.to_owned()).or_default() += count;
    }
    if counts.values().sum::<u64>() == 0 {
        return Err("--counts: found none, expected name=number or --design; name what to pick".to_owned());
    }
    Ok(counts)
}
