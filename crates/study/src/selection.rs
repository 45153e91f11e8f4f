//! The table of realizations of a selection study.

use artifact::{Columns, Error, Table, TableReader, TableSchema};
use identification::ScoreStatus;
use identification::pooled::{NominalSource, Pool};
use identification::selection::{DEGENERATE, Realization, Selected, Selection, SelectionOptions};
use vessel::DegreeOfFreedom;

use crate::documents::{
    PublishedLimits, Quantiles, SelectionDocument, SelectionErrors, SelectionScores, Share, SharesBeyond,
};

/// Schema id of the realizations of a selection study.
pub const ID: &str = "selection-realizations";
/// Version of the schema.
pub const VERSION: u32 = 1;

/// One realization.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Row {
    /// `optimized` or `random`.
    pub design: String,
    /// Its number.
    pub realization: i32,
    /// Numbers of the parts, in the order of the trajectories: `3 17 40`.
    pub picked: String,
    /// Whether there is a model.
    pub identified: bool,
    /// Over all parts: RMSE of u, v, r; absent where diverged.
    pub rmse: Option<[f64; 3]>,
    /// Norm of RMSE/std.
    pub error_norm: Option<f64>,
    /// The same over the parts that were not picked.
    pub left_out_rmse: Option<[f64; 3]>,
    /// The same.
    pub left_out_norm: Option<f64>,
}

impl Row {
    /// What became of a realization of `design`.
    pub fn of(design: &str, realization: &Realization) -> Self {
        let picked: Vec<String> = realization.picked.iter().map(usize::to_string).collect();
        let Realization { number, overlapping, left_out, status, .. } = realization;
        Self {
            design: design.to_owned(),
            realization: *number as i32,
            picked: picked.join(" "),
            identified: *status != ScoreStatus::NotIdentifiable,
            rmse: overlapping.map(|e| e.rmse),
            error_norm: overlapping.and_then(|e| e.norm()),
            left_out_rmse: left_out.map(|e| e.rmse),
            left_out_norm: left_out.and_then(|e| e.norm()),
        }
    }

    fn status(&self) -> ScoreStatus {
        match (self.identified, self.rmse) {
            (false, _) => ScoreStatus::NotIdentifiable,
            (true, None) => ScoreStatus::Diverged,
            (true, Some(_)) => ScoreStatus::Scored,
        }
    }
}

/// The columns.
pub fn schema() -> TableSchema {
    columns().schema().clone()
}

/// Rows as a block of the table.
pub fn table(rows: &[Row]) -> Table {
    columns().table(rows)
}

/// Reads the whole table.
///
/// # Errors
/// Missing columns, damaged blocks.
pub fn rows(reader: &TableReader) -> Result<Vec<Row>, Error> {
    let blank = Row { rmse: Some([0.0; 3]), left_out_rmse: Some([0.0; 3]), ..Row::default() };
    columns().read(reader, &blank)
}

fn columns() -> Columns<Row> {
    let columns = Columns::<Row>::new(ID, VERSION)
        .text("design", |r| &r.design, |r, design| r.design = design.to_owned())
        .integer("realization", "1", |r| r.realization, |r, number| r.realization = number)
        .text("picked", |r| &r.picked, |r, picked| r.picked = picked.to_owned())
        .choice("status", Row::status, |r, status| r.identified = status != ScoreStatus::NotIdentifiable);
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

/// One row per realization.
pub fn rows_of(found: &Selection) -> Vec<Row> {
    let of = |selected: &Selected| {
        selected.realizations.iter().map(|r| Row::of(selected.design, r)).collect::<Vec<_>>()
    };
    found.designs.iter().flat_map(of).collect()
}

/// What `found` says, of which `rows` are the realizations, with instruments from `nominal`.
pub fn document(
    pool: &Pool,
    nominal: NominalSource,
    options: &SelectionOptions,
    found: &Selection,
    rows: &[Row],
    published_limits: Option<PublishedLimits>,
) -> SelectionDocument {
    let [std_u, std_v, std_r] = found.std;
    let design = |selected: &Selected| summarize(selected.design, rows, DEGENERATE, published_limits);
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
        published_limits,
        ratio_q90: found.ratio_q90,
        statements: found.statements.clone(),
        instrument_fit: found.instrument_fit,
        designs: found.designs.iter().map(design).collect(),
    }
}

/// What the realizations of one design say together. A realization is degenerate from this norm of RMSE/std on.
fn summarize(
    design: &str,
    rows: &[Row],
    degenerate_from: f64,
    limits: Option<PublishedLimits>,
) -> SelectionScores {
    let own = || rows.iter().filter(move |r| r.design == design);
    let count = own().count();
    let degenerate = own().filter(|r| r.error_norm.is_none_or(|norm| norm >= degenerate_from)).count();
    let degenerate = Share::of(degenerate, count);
    let errors = |rmse: fn(&Row) -> Option<[f64; 3]>, relative: fn(&Row) -> Option<f64>| {
        let state = |d: usize| Quantiles::of(own().map(move |r| rmse(r).map(|e| e[d])));
        SelectionErrors {
            error_norm: Quantiles::of(own().map(relative)),
            rmse_norm: Quantiles::of(own().map(|r| rmse(r).map(norm))),
            rmse_u: state(0),
            rmse_v: state(1),
            rmse_r: state(2),
        }
    };
    SelectionScores {
        design: design.to_owned(),
        realizations: count as u64,
        not_identifiable: own().filter(|r| !r.identified).count() as u64,
        diverged: own().filter(|r| r.identified && r.rmse.is_none()).count() as u64,
        degenerate_share: degenerate.share,
        degenerate_share_interval: degenerate.interval,
        beyond_published: limits.map(|limits| beyond(&own().collect::<Vec<_>>(), limits)),
        overlapping: errors(|r| r.rmse, |r| r.error_norm),
        left_out: errors(|r| r.left_out_rmse, |r| r.left_out_norm),
    }
}

/// Shares of `rows` at or above the published limits.
fn beyond(rows: &[&Row], limits: PublishedLimits) -> SharesBeyond {
    let share = |limit: f64, error: &dyn Fn([f64; 3]) -> f64| {
        Share::of(rows.iter().filter(|r| r.rmse.is_none_or(|rmse| error(rmse) >= limit)).count(), rows.len())
    };
    SharesBeyond {
        norm: share(limits.rmse_norm, &norm),
        surge: share(limits.rmse_u, &|rmse| rmse[0]),
        sway: share(limits.rmse_v, &|rmse| rmse[1]),
        yaw: share(limits.rmse_r, &|rmse| rmse[2]),
    }
}

/// Norm of the three RMSE as numbers.
fn norm(rmse: [f64; 3]) -> f64 {
    rmse.iter().map(|e| e * e).sum::<f64>().sqrt()
}
