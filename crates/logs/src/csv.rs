//! Logs as CSV: the columns that are asked for.
//!
//! A row is a line: a quote that nobody closes spoils its own row and not the rest of the file, lines have the numbers that
//! an editor shows, and blank lines are counted. Hence no general reader of CSV, whose rows go on over lines and which
//! passes over blank ones in silence.

use std::io::BufRead;

use thiserror::Error;

use crate::columns::{Cells, Columns, MissingColumns, Wanted, places};

/// Why a text is no log.
#[derive(Debug, Error)]
pub enum CsvError {
    /// The bytes cannot be read.
    #[error("{0}")]
    Unreadable(#[from] std::io::Error),
    /// A line that is not UTF-8.
    #[error("a byte that is not UTF-8 (line {0})")]
    NotText(usize),
    /// A line with more or fewer cells than the header.
    #[error("line {line}: {found} cells instead of {expected}")]
    Width {
        /// The line, from 1.
        line: usize,
        /// Its cells.
        found: usize,
        /// Those of the header.
        expected: usize,
    },
    /// A cell that is no number.
    #[error("line {line}, column `{column}`: `{found}` is no number")]
    NoNumber {
        /// The line, from 1.
        line: usize,
        /// The column.
        column: String,
        /// The cell.
        found: String,
    },
    /// The whole header is one cell, with another separator in it.
    #[error("{cells} cells separated by {found:?} instead of {expected:?}")]
    Separator {
        /// Cells between separators as they are.
        cells: usize,
        /// The separator as it is.
        found: char,
        /// The separator that was named.
        expected: char,
    },
    /// Columns that are not there.
    #[error(transparent)]
    Columns(#[from] MissingColumns),
}

/// What stands for no value.
const NOTHING: [&str; 8] = ["", "nan", "na", "n/a", "null", "inf", "+inf", "-inf"];

/// What separates cells in files that do not separate them as was said.
const SEPARATORS: [char; 4] = [';', '\t', ',', '|'];

/// Reads the `wanted` columns of CSV with a header.
///
/// # Errors
/// Bytes that cannot be read or are no text, missing columns (all at once), a cell that is no number, a row that is too
/// long or too short. The last row may be too short: then it is left out and counted.
pub fn read_csv(bytes: impl BufRead, separator: char, wanted: &[Wanted]) -> Result<Columns, CsvError> {
    let mut lines = Lines { bytes, line: Vec::new(), number: 0 };
    let mut row = Row::default();
    row.split(lines.next()?.unwrap_or_default().trim_start_matches('\u{feff}'), separator);
    let header: Vec<String> = row.cells().map(|cell| cell.trim().to_owned()).collect();
    let places = places(&header, wanted).map_err(|missing| other_separator(&header, separator, missing))?;
    let empty = |w: &Wanted| if w.text { Cells::Texts(Vec::new()) } else { Cells::Numbers(Vec::new()) };
    let cells = wanted.iter().map(empty).collect();
    let mut columns = Columns { cells, lines: Vec::new(), empty_rows: 0, cut_rows: 0 };
    let mut short = None;
    while let Some(line) = lines.next()? {
        if let Some(short) = short {
            return Err(short);
        }
        row.split(line, separator);
        let (line, found, expected) = (lines.number, row.ends.len(), header.len());
        if row.cells().all(|cell| cell.trim().is_empty()) {
            columns.empty_rows += 1;
        } else if found == expected {
            columns.lines.push(line);
            for (cells, place) in columns.cells.iter_mut().zip(&places) {
                push(cells, row.cell(*place).trim()).map_err(|found| {
                    let column = header[*place].clone();
                    CsvError::NoNumber { line, column, found }
                })?;
            }
        } else if found < expected {
            short = Some(CsvError::Width { line, found, expected });
        } else {
            return Err(CsvError::Width { line, found, expected });
        }
    }
    columns.cut_rows = usize::from(short.is_some());
    Ok(columns)
}

/// The lines of a text, one at a time.
struct Lines<B> {
    bytes: B,
    line: Vec<u8>,
    /// Number of the line, from 1.
    number: usize,
}

impl<B: BufRead> Lines<B> {
    /// The next line, without its end.
    fn next(&mut self) -> Result<Option<&str>, CsvError> {
        self.line.clear();
        if self.bytes.read_until(b'\n', &mut self.line)? == 0 {
            return Ok(None);
        }
        self.number += 1;
        let line = self.line.strip_suffix(b"\n").unwrap_or(&self.line);
        let line = line.strip_suffix(b"\r").unwrap_or(line);
        std::str::from_utf8(line).map(Some).map_err(|_| CsvError::NotText(self.number))
    }
}

/// The cells of a line. Used again for every line, so that no line is allocated.
#[derive(Default)]
struct Row {
    /// The cells' texts, one after the other.
    text: String,
    /// Where each ends.
    ends: Vec<usize>,
}

impl Row {
    /// A cell in quotes may contain the separator, and quotes written twice.
    fn split(&mut self, line: &str, separator: char) {
        self.text.clear();
        self.ends.clear();
        if !line.contains('"') {
            for cell in line.split(separator) {
                self.text.push_str(cell);
                self.ends.push(self.text.len());
            }
            return;
        }
        let mut quoted = false;
        let mut characters = line.chars().peekable();
        while let Some(c) = characters.next() {
            match c {
                '"' if quoted && characters.next_if_eq(&'"').is_some() => self.text.push('"'),
                '"' => quoted = !quoted,
                c if c == separator && !quoted => self.ends.push(self.text.len()),
                c => self.text.push(c),
            }
        }
        self.ends.push(self.text.len());
    }

    fn cell(&self, place: usize) -> &str {
        let start = if place == 0 { 0 } else { self.ends[place - 1] };
        &self.text[start..self.ends[place]]
    }

    fn cells(&self) -> impl Iterator<Item = &str> {
        (0..self.ends.len()).map(|place| self.cell(place))
    }
}

/// Appends `cell`; itself where a number is needed and it is none.
fn push(cells: &mut Cells, cell: &str) -> Result<(), String> {
    match cells {
        Cells::Texts(texts) => texts.push(cell.to_owned()),
        Cells::Numbers(numbers) => match cell.parse::<f64>() {
            Ok(number) => numbers.push(number),
            Err(_) if NOTHING.contains(&cell.to_ascii_lowercase().as_str()) => numbers.push(f64::NAN),
            Err(_) => return Err(cell.to_owned()),
        },
    }
    Ok(())
}

/// Whether columns are missing because the header, one cell as a whole, is separated by something else.
fn other_separator(header: &[String], expected: char, missing: MissingColumns) -> CsvError {
    let within = |only: &String| SEPARATORS.into_iter().find(|c| *c != expected && only.contains(*c));
    match header {
        [only] => match within(only) {
            Some(found) => CsvError::Separator { cells: only.matches(found).count() + 1, found, expected },
            None => missing.into(),
        },
        _ => missing.into(),
    }
}
