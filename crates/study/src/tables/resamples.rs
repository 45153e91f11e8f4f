//! The table of resamples: the bootstrap of a pooled estimate, if it is computed in shards.

use std::path::Path;

pub use estimation::pooled::Resample as Row;
use files::{Columns, Error, TableReader};
use ship::model::Vessel;

/// Schema id.
pub const ID: &str = "resamples";
/// Version of the schema.
pub const VERSION: u32 = 1;
/// The usual name of the table.
pub const MAIN: &str = "resamples.parquet";

/// Least number of resamples in a block: with at least eight times as many resamples as shards, no shard is empty.
const FEWEST: u32 = 8;
/// Maximum number of blocks; a footer lists them all.
const MOST: u32 = 2048;

/// The number of blocks of `replicates` resamples, and the resamples per block.
pub fn blocks(replicates: u32) -> (usize, u32) {
    let each = replicates.div_ceil(MOST).max(FEWEST);
    (replicates.div_ceil(each) as usize, each)
}

/// The columns for `vessel`: its parameters, null if the resample has no estimate.
pub fn columns(vessel: &Vessel) -> Columns<Row> {
    let columns = Columns::new(ID, VERSION).integer(
        "resample",
        "1",
        |r: &Row| r.number as i32,
        |r, number| r.number = number as u32,
    );
    let parameters = vessel.model.parameter_names().zip(vessel.model.parameter_units());
    parameters.enumerate().fold(columns, |columns, (i, (name, unit))| {
        columns.optional(name, &unit, move |r| r.theta[i], move |r, value| r.theta[i] = value)
    })
}

/// Reads the whole table.
///
/// # Errors
/// Missing columns, damaged blocks.
pub fn rows(reader: &TableReader, vessel: &Vessel) -> Result<Vec<Row>, Error> {
    columns(vessel).read(reader, &Row { number: 0, theta: vec![None; vessel.model.parameters()] })
}

/// Refuses rows that are not those of `replicates` resamples, gathered from `file` and others.
///
/// # Errors
/// Names the first resample that is missing or out of place.
pub fn check(rows: &[Row], replicates: u32, file: &Path) -> Result<(), Error> {
    let expected = (0..replicates).map(Some).chain([None]);
    let mut numbers = rows.iter().map(|row| Some(row.number)).chain([None]).zip(expected);
    match numbers.find(|(number, expected)| number != expected) {
        None => Ok(()),
        Some((found, expected)) => {
            let text = |number: Option<u32>| {
                number.map_or("no more".to_owned(), |number| format!("resample {number}"))
            };
            let remedy = "write the shards again";
            Err(crate::refuse(file, "`resample`", &text(found), &text(expected), remedy))
        }
    }
}
