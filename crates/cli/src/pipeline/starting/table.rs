//! The first rows of a log in Parquet.

use std::path::Path;

use files::{Error, ForeignTable, Timed};
use logs::guess::Head;

/// Endings of files in Parquet.
pub(super) const PARQUET: [&str; 1] = [".parquet"];

/// Rows that are looked at.
const ROWS: usize = 400;

/// The columns and first rows of the file at `path`, and how many rows it has.
///
/// # Errors
/// A file that is not a whole Parquet file.
pub(super) fn head(path: &Path) -> Result<(Head, usize), Error> {
    let table = ForeignTable::open(path)?;
    let columns = table.columns().to_vec();
    let cells: Vec<Vec<String>> = columns.iter().map(|column| first(&table, column)).collect();
    Ok((Head::of_cells(columns, &cells), table.rows()))
}

/// The first cells of `column`, times of a type as text; none of a type that holds nothing for a log.
fn first(table: &ForeignTable, column: &str) -> Vec<String> {
    let mut cells = Vec::new();
    let mut keep = |cell: String| {
        if cells.len() < ROWS {
            cells.push(cell);
        }
    };
    // What cannot be read is refused when the file is ingested, if it is needed there.
    let _ = match table.timed(column) {
        Some(Timed::Moments { .. } | Timed::OfDay { .. }) => {
            table.seconds(column, |second| keep(of_day(second)))
        }
        Some(Timed::Days) => Ok(()),
        None => table
            .numbers(column, |number| {
                keep(if number.is_finite() { number.to_string() } else { String::new() })
            })
            .or_else(|_| table.texts(column, |text| keep(text.to_owned()))),
    };
    cells
}

/// A time \[s\] as text: of which day says nothing about the step between rows.
fn of_day(second: f64) -> String {
    let second = second.rem_euclid(86_400.0);
    let (hours, minutes) = ((second / 3600.0).floor(), (second / 60.0).floor() % 60.0);
    match second.is_finite() {
        true => format!("1970-01-01T{hours:02}:{minutes:02}:{:09.6}", second % 60.0),
        false => String::new(),
    }
}
