//! Logs as CSV: the columns that are asked for.
//!
//! A row is a line: a quote that nobody closes spoils its own row and not the rest of the file, lines have the numbers that
//! an editor shows, and blank lines are counted. Hence no general reader of CSV, whose rows go on over lines and which
//! passes over blank ones in silence.

use std::io::BufRead;
use std::sync::Arc;

use refusal::{Invalid, foreign};

use crate::columns::{Cells, Columns, Content, Wanted, cell_of, is_nothing, places};
use crate::lines::Lines;
use crate::row::{Ends, Row};
use crate::{FileSpec, LogError, Moments, Plan, Store};

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
pub fn read_csv<'a>(
    bytes: impl BufRead + 'a,
    length: Option<u64>,
    plan: &Plan,
    group: usize,
    store: Option<&Arc<dyn Store>>,
) -> Result<Columns, LogError> {
    let mut lines = Lines::new(bytes)?;
    let mut row = Row::default();
    let mut reading =
        Reading::new(plan, group, store, header(&plan.setup.files[group], &mut lines, &mut row)?)?;
    while let Some(line) = lines.next()? {
        row.split(line, reading.spec.separator);
        reading.take(&row, lines.number, lines.is_ended)?;
        if let (Some(length), TYPICAL) = (length, reading.columns.lines.rows()) {
            let rows = (TYPICAL as f64 * length as f64 / lines.read as f64) as usize;
            if rows / 2 > plan.most_rows {
                return Err(LogError::Invalid(plan.too_many_rows(format_args!("about {rows}"))));
            }
        }
    }
    Ok(reading.finish())
}

/// What is read so far.
struct Reading<'a> {
    plan: &'a Plan,
    spec: &'a FileSpec,
    wanted: Vec<Wanted>,
    header: Vec<String>,
    /// Columns without those at the end that have no name.
    named: usize,
    /// Where the wanted columns stand.
    places: Vec<usize>,
    columns: Columns,
    moments: Moments<'a>,
    /// Whether decimals of the time are looked at.
    has_fractions: bool,
    /// What is said of a row that is too short, unless it is the last.
    short: Option<Invalid>,
    ends: Ends,
}

impl<'a> Reading<'a> {
    fn new(
        plan: &'a Plan,
        group: usize,
        store: Option<&Arc<dyn Store>>,
        header: Vec<String>,
    ) -> Result<Self, LogError> {
        let (wanted, spec) = (plan.wanted(group), &plan.setup.files[group]);
        let places = places(&header, &wanted).map_err(|missing| {
            other_separator(&header, spec.separator, plan.setup.written_in).unwrap_or(missing)
        })?;
        let cells = wanted.iter().map(|w| Cells::none(w.content, store)).collect();
        let named = header.iter().rposition(|name| !name.is_empty()).map_or(0, |last| last + 1);
        Ok(Self {
            plan,
            spec,
            wanted,
            header,
            named,
            places,
            columns: Columns { cells, ..Columns::default() },
            moments: Moments::new(plan.stamps(group)),
            has_fractions: spec.time.has_fractions(),
            short: None,
            ends: Ends::default(),
        })
    }

    /// Takes the row that stands on `line`, which may have no end.
    fn take(&mut self, row: &Row, line: usize, is_ended: bool) -> Result<(), LogError> {
        if let Some(short) = self.short.take() {
            return Err(LogError::Invalid(short));
        }
        let (found, most) = (row.cells.len(), self.plan.most_rows);
        let is_blank = |cell: &str| cell.trim().is_empty();
        // An empty cell after the last column is none.
        let fits = found == self.header.len()
            || found >= self.named && row.cells().skip(self.header.len()).all(is_blank);
        if row.cells().all(is_blank) || self.is_header(row) {
            self.columns.empty_rows += 1;
        } else if fits && !is_ended && self.ends.is_cut(row) {
            self.columns.cut_rows += 1;
        } else if fits {
            self.ends.see(row);
            self.cells(row, line)?;
        } else if found < self.named {
            self.short = Some(self.wrong_width(row, line));
        } else {
            return Err(LogError::Invalid(self.wrong_width(row, line)));
        }
        if self.columns.lines.rows() > most || self.columns.empty_rows > most.max(TYPICAL) {
            return Err(LogError::Invalid(self.plan.too_many_rows(line)));
        }
        Ok(())
    }

    /// Whether a row is the header once more, as where a logger was started again.
    fn is_header(&self, row: &Row) -> bool {
        let is = |(cell, name): (&str, &String)| cell.trim() == name;
        self.spec.header && row.cells.len() == self.header.len() && row.cells().zip(&self.header).all(is)
    }

    fn cells(&mut self, row: &Row, line: usize) -> Result<(), LogError> {
        self.columns.lines.push(line);
        if self.has_fractions {
            self.columns.clock.fractions.see(row.cell(self.places[0]), self.spec.decimal);
        }
        let (written_in, decimal) = (self.plan.setup.written_in, self.spec.decimal);
        for ((cells, place), wanted) in self.columns.cells.iter_mut().zip(&self.places).zip(&self.wanted) {
            let (cell, column) = (row.cell(*place).trim(), &self.header[*place]);
            match (wanted.content, cells) {
                (Content::Dates, Cells::Numbers(numbers)) => {
                    let stamps = self.moments.stamps;
                    let time = self.moments.next(cell);
                    numbers.push(time.map_err(|why| stamps.refused(line, column, cell, why, written_in))?);
                }
                (_, cells) => push(cells, decimal, cell)
                    .ok_or_else(|| no_number(line, column, cell, decimal, written_in))?,
            }
        }
        Ok(())
    }

    fn finish(mut self) -> Columns {
        self.columns.cut_rows += usize::from(self.short.is_some());
        self.columns.clock.leap_s = self.moments.leap_s();
        self.columns.clock.of_day = self.moments.stamps.of_day();
        self.columns
    }

    fn wrong_width(&self, row: &Row, line: usize) -> Invalid {
        let (found, expected) = (row.cells.len(), self.header.len());
        let is_whole = |cell: &str| cell.trim().bytes().all(|b| b.is_ascii_digit() || b"+-".contains(&b));
        let has_commas = self.spec.separator == ','
            && found > expected
            && found <= 2 * expected
            && row.cells().all(is_whole);
        let remedy = if has_commas {
            " (decimal commas: export with decimal points, or another separator)"
        } else if found > expected {
            " (a cell that holds the separator stands in quotes)"
        } else {
            ""
        };
        let (as_in, columns) =
            if self.spec.header { ("in the header", "") } else { ("`columns` says", ", `columns`") };
        Invalid::new(
            format!("line {line}"),
            format!("{found} cells"),
            format!("{expected}, as {as_in}"),
            format!("correct the line, or `separator`{columns} in {}{remedy}", self.plan.setup.written_in),
        )
    }
}

/// The names of the columns: those of the header, or their numbers where there is none.
fn header(spec: &FileSpec, lines: &mut Lines, row: &mut Row) -> Result<Vec<String>, LogError> {
    for _ in 0..spec.skip_lines {
        lines.next()?;
    }
    if !spec.header {
        return Ok((1..=spec.columns.unwrap_or(0)).map(|number| number.to_string()).collect());
    }
    row.split(lines.next()?.unwrap_or_default(), spec.separator);
    Ok(row.cells().map(|cell| cell.trim().to_owned()).collect())
}

fn no_number(line: usize, column: &str, found: &str, decimal: char, written_in: &str) -> Invalid {
    let other = if decimal == '.' { ',' } else { '.' };
    let comma = found.contains(other) && found.replacen(other, ".", 1).parse::<f64>().is_ok();
    let remedy = if comma {
        format!("set `decimal = \"{other}\"` in {written_in}, or export with decimal points")
    } else {
        "correct the cell or leave it empty".to_owned()
    };
    let expected = if decimal == ',' { "a number with a decimal comma" } else { "a number" };
    Invalid::new(cell_of(line, &foreign(column)), format!("`{}`", foreign(found)), expected, remedy)
}

/// Appends a number or a label; nothing where it is not what its column holds.
fn push(cells: &mut Cells, decimal: char, cell: &str) -> Option<()> {
    match cells {
        Cells::Labels(labels) => labels.push(cell),
        Cells::Numbers(numbers) => numbers.push(number(cell, decimal)?),
    }
    Some(())
}

fn number(cell: &str, decimal: char) -> Option<f64> {
    let parsed = match decimal {
        '.' => cell.parse().ok(),
        // A point between thousands would be taken for that before the decimals.
        _ if cell.contains('.') => None,
        _ => cell.replacen(decimal, ".", 1).parse().ok(),
    };
    parsed.or_else(|| is_nothing(cell).then_some(f64::NAN))
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
