//! Logs as CSV: the columns that are asked for.
//!
//! A row is a line: a quote that nobody closes spoils its own row and not the rest of the file, lines have the numbers that
//! an editor shows, and blank lines are counted. Hence no general reader of CSV, whose rows go on over lines and which
//! passes over blank ones in silence.

use std::io::{self, BufRead, Read};
use std::sync::Arc;

use refusal::Invalid;

use crate::columns::{Cells, Columns, Content, Numbering, cell_of, no_date, places, seconds_of};
use crate::{Plan, Store};

/// Why a text is no log.
#[derive(Debug)]
pub enum CsvError {
    /// The bytes cannot be read.
    Unreadable(io::Error),
    /// They can, and are no log.
    Invalid(Invalid),
}

impl From<io::Error> for CsvError {
    fn from(error: io::Error) -> Self {
        Self::Unreadable(error)
    }
}

impl From<Invalid> for CsvError {
    fn from(invalid: Invalid) -> Self {
        Self::Invalid(invalid)
    }
}

/// What stands for no value.
const NOTHING: [&str; 8] = ["", "nan", "na", "n/a", "null", "inf", "+inf", "-inf"];

/// Bytes from which on a line is taken to be none.
const LONGEST_LINE: u64 = 1 << 20;

/// What separates cells in files that do not separate them as was said.
const SEPARATORS: [char; 4] = [';', '\t', ',', '|'];

/// Rows after which it is known how long rows are.
const TYPICAL: usize = 1024;

/// Reads the columns of CSV with a header that `plan` wants of files of group `group`; numbers are put aside in `store`. Where
/// the text's `length` in bytes is known, too many rows are refused before they are all read.
///
/// # Errors
/// Bytes that cannot be read or are no text, missing columns (all at once), a cell that is no number, a row that is too
/// long or too short. The last row may be too short: then it is left out and counted.
pub fn read_csv(
    bytes: impl BufRead,
    length: Option<u64>,
    plan: &Plan,
    group: usize,
    store: Option<&Arc<dyn Store>>,
) -> Result<Columns, CsvError> {
    let (wanted, separator, written_in) =
        (plan.wanted(group), plan.setup.files[group].separator, plan.setup.written_in);
    let mut lines = Lines { bytes, line: Vec::new(), number: 0, read: 0 };
    let mut row = Row::default();
    row.split(lines.next()?.unwrap_or_default().trim_start_matches('\u{feff}'), separator);
    let header: Vec<String> = row.cells().map(|cell| cell.trim().to_owned()).collect();
    let places = places(&header, &wanted)
        .map_err(|missing| other_separator(&header, separator, written_in).unwrap_or(missing))?;
    let cells = wanted.iter().map(|w| Cells::none(w.content, store)).collect();
    let mut columns = Columns { cells, lines: Numbering::default(), empty_rows: 0, cut_rows: 0 };
    let mut short = None;
    while let Some(line) = lines.next()? {
        if let Some(short) = short {
            return Err(CsvError::Invalid(short));
        }
        row.split(line, separator);
        let (line, found, expected) = (lines.number, row.ends.len(), header.len());
        if row.cells().all(|cell| cell.trim().is_empty()) {
            columns.empty_rows += 1;
        } else if found == expected {
            if columns.lines.rows() >= plan.most_rows {
                return Err(CsvError::Invalid(plan.too_many_rows(line)));
            }
            if let (Some(length), TYPICAL) = (length, columns.lines.rows()) {
                let rows = (TYPICAL as f64 * length as f64 / lines.read as f64) as usize;
                if rows / 2 > plan.most_rows {
                    return Err(CsvError::Invalid(plan.too_many_rows(format_args!("about {rows}"))));
                }
            }
            columns.lines.push(line);
            for ((cells, place), wanted) in columns.cells.iter_mut().zip(&places).zip(&wanted) {
                let cell = row.cell(*place).trim();
                push(cells, wanted.content, cell).ok_or_else(|| match wanted.content {
                    Content::Dates => no_date(line, &header[*place], cell, written_in),
                    _ => no_number(line, &header[*place], cell),
                })?;
            }
        } else if found < expected {
            short = Some(wrong_width(line, found, expected, written_in));
        } else {
            return Err(CsvError::Invalid(wrong_width(line, found, expected, written_in)));
        }
    }
    columns.cut_rows = usize::from(short.is_some());
    Ok(columns)
}

fn wrong_width(line: usize, found: usize, expected: usize, written_in: &str) -> Invalid {
    let comma = if found > expected { " (decimal commas: export with decimal points)" } else { "" };
    Invalid::new(
        format!("line {line}"),
        format!("{found} cells"),
        format!("{expected}, as in the header"),
        format!("correct the line, or `separator` in {written_in}{comma}"),
    )
}

fn no_number(line: usize, column: &str, found: &str) -> Invalid {
    let comma = found.replacen(',', ".", 1).parse::<f64>().is_ok();
    let remedy = if comma { "export with decimal points" } else { "correct the cell or leave it empty" };
    Invalid::new(cell_of(line, column), format!("`{found}`"), "a number", remedy)
}

/// The lines of a text, one at a time.
struct Lines<B> {
    bytes: B,
    line: Vec<u8>,
    /// Number of the line, from 1.
    number: usize,
    /// Bytes of all lines so far.
    read: u64,
}

impl<B: BufRead> Lines<B> {
    /// The next line, without its end.
    fn next(&mut self) -> Result<Option<&str>, CsvError> {
        self.line.clear();
        if (&mut self.bytes).take(LONGEST_LINE).read_until(b'\n', &mut self.line)? == 0 {
            return Ok(None);
        }
        self.number += 1;
        self.read += self.line.len() as u64;
        if self.line.len() as u64 == LONGEST_LINE {
            return Err(CsvError::Invalid(Invalid::new(
                format!("line {}", self.number),
                format!("{LONGEST_LINE} bytes without an end of the line"),
                "a row of cells",
                "correct or leave out the file: it is damaged, or no CSV",
            )));
        }
        let line = self.line.strip_suffix(b"\n").unwrap_or(&self.line);
        let line = line.strip_suffix(b"\r").unwrap_or(line);
        std::str::from_utf8(line).map(Some).map_err(|_| {
            let found = format!("a byte that is not UTF-8 (line {})", self.number);
            CsvError::Invalid(Invalid::new("text", found, "UTF-8 text", "save the file as UTF-8"))
        })
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

/// Appends `cell`; nothing where it is not what its column holds.
fn push(cells: &mut Cells, content: Content, cell: &str) -> Option<()> {
    let no_value = || NOTHING.contains(&cell.to_ascii_lowercase().as_str()).then_some(f64::NAN);
    match cells {
        Cells::Labels(labels) => labels.push(cell),
        Cells::Numbers(numbers) => numbers.push(match content {
            Content::Dates => seconds_of(cell)?,
            _ => cell.parse().ok().or_else(no_value)?,
        }),
    }
    Some(())
}

/// What is said where columns are missing because the header, one cell as a whole, is separated by something else.
fn other_separator(header: &[String], expected: char, written_in: &str) -> Option<Invalid> {
    let [only] = header else { return None };
    let found = SEPARATORS.into_iter().find(|c| *c != expected && only.contains(*c))?;
    Some(Invalid::new(
        "line 1",
        format!("{} cells separated by {found:?}", only.matches(found).count() + 1),
        format!("cells separated by {expected:?}"),
        format!("set `separator = {:?}` in {written_in}", found.to_string()),
    ))
}
