//! The beginning of a log as text, and its columns as numbers.

use std::io::{BufRead, Cursor};

use refusal::{Invalid, foreign};

use crate::LogError;
use crate::by_motion::LoggedTable;
use crate::csv::LineCells;
use crate::encoding::Lines;

/// Separators that are tried, the likeliest first.
const SEPARATORS: [char; 4] = [';', '\t', '|', ','];

/// Rows that are looked at.
const ROWS: usize = 400;

/// A day \[s\].
const DAY: f64 = 86_400.0;

/// The columns of a log and its first rows.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Head {
    /// What stands between cells.
    pub separator: char,
    /// What stands before the decimals.
    pub decimal: char,
    /// Names of the columns; empty for one that has none.
    pub columns: Vec<String>,
    /// Whether the first line has the names; else columns are called by their numbers.
    pub has_header: bool,
    /// Lines before it.
    pub skip_lines: usize,
    /// Bytes of a row, about.
    pub row_bytes: f64,
    /// Rows of cells.
    rows: Vec<Vec<String>>,
}

impl Head {
    /// The columns and rows of `text`.
    ///
    /// # Errors
    /// See [`Head::read`].
    pub fn of_csv(text: &str) -> Result<Self, LogError> {
        Self::read(Cursor::new(text.as_bytes()))
    }

    /// The columns and first rows of a text; its last line may be cut off.
    ///
    /// # Errors
    /// Bytes that cannot be read; no separator, no row of numbers.
    pub fn read(bytes: impl BufRead) -> Result<Self, LogError> {
        let (mut lines, mut all) = (Lines::new(bytes)?, Vec::<String>::new());
        while all.len() < ROWS
            && let Some((_, line)) = lines.bytes()?
        {
            all.push(String::from_utf8_lossy(line).into_owned());
        }
        let row_bytes = lines.read as f64 / all.len().max(1) as f64;
        // What Excel writes before the names.
        let said = all.first().and_then(|line| line.strip_prefix("sep=")?.chars().next());
        let skip_lines = usize::from(said.is_some());
        let mut rest: Vec<&str> =
            all[skip_lines..].iter().map(String::as_str).filter(|line| !line.trim().is_empty()).collect();
        if rest.len() > 2 {
            rest.pop();
        }
        let Some((first, below)) = rest.split_first().filter(|(_, below)| !below.is_empty()) else {
            return Err(refused("fewer than two lines"));
        };
        let width = |line: &str, separator: char| cells(line, separator).len();
        let fits = |separator: &char| {
            width(first, *separator) > 1
                && below.iter().all(|line| width(line, *separator) == width(first, *separator))
        };
        // A comma may stand before decimals, too.
        let likely = said
            .or(SEPARATORS.into_iter().find(fits))
            .or([',', ';', '\t', '|'].into_iter().find(|c| width(first, *c) > 1));
        let Some(separator) = likely else { return Err(refused("a first line without separators")) };
        let names = cells(first, separator);
        let rows: Vec<Vec<String>> = below.iter().map(|line| cells(line, separator)).collect();
        let has_comma = separator != ','
            && rows.iter().flatten().any(|cell| number(cell, ',').is_some() && cell.contains(','));
        let decimal = if has_comma { ',' } else { '.' };
        let is_value = |cell: &String| number(cell, decimal).is_some() || iso_seconds(cell).is_some();
        let values = names.iter().filter(|name| is_value(name)).count();
        let has_header = values == 0;
        if !has_header && names.iter().any(|name| !name.is_empty() && !is_value(name) && name.len() > 3) {
            let number = names.iter().find(|name| is_value(name)).map_or("", String::as_str);
            return Err(refused(&format!("`{}` in the first line", foreign(number))));
        }
        let columns =
            if has_header { names } else { (1..=names.len()).map(|number| number.to_string()).collect() };
        Ok(Self { separator, decimal, columns, has_header, skip_lines, row_bytes, rows })
    }

    /// The columns of a table that is not text: their names, and the first cells of each as text.
    pub fn of_cells(columns: Vec<String>, cells: &[Vec<String>]) -> Self {
        let rows = cells.iter().map(Vec::len).max().unwrap_or(0);
        let row =
            |at: usize| cells.iter().map(|column| column.get(at).cloned().unwrap_or_default()).collect();
        let rows = (0..rows.min(ROWS)).map(row).collect();
        Self { separator: ',', decimal: '.', columns, has_header: true, rows, ..Self::default() }
    }

    /// The first rows as a table of one recording.
    pub fn table(&self) -> LoggedTable {
        let column = |at: usize| {
            self.rows.iter().map(|row| self.value(row.get(at).map_or("", String::as_str))).collect()
        };
        LoggedTable::of(vec![(1, (0..self.columns.len()).map(column).collect())])
    }

    /// The numbers in one of `every` rows of a text with these columns; times as text in seconds; NaN for what is none.
    ///
    /// # Errors
    /// Bytes that cannot be read.
    pub fn numbers_of(&self, bytes: impl BufRead, every: usize) -> Result<Vec<Vec<f64>>, LogError> {
        let (mut lines, mut row) = (Lines::new(bytes)?, LineCells::default());
        let mut columns = vec![Vec::new(); self.columns.len()];
        let first = self.skip_lines + usize::from(self.has_header);
        while let Some((number, line)) = lines.bytes()? {
            if number <= first || !(number - first - 1).is_multiple_of(every) {
                continue;
            }
            row.split(&String::from_utf8_lossy(line), self.separator);
            if row.cells.len() == columns.len() {
                columns.iter_mut().zip(row.cells()).for_each(|(column, cell)| column.push(self.value(cell)));
            }
        }
        // Days without a date pass.
        for column in
            columns.iter_mut().zip(0..).filter(|(_, at)| self.has_iso_times(*at)).map(|(column, _)| column)
        {
            let mut days = 0.0;
            for row in 1..column.len() {
                days += if column[row] + days < column[row - 1] - 0.5 * DAY { DAY } else { 0.0 };
                column[row] += days;
            }
        }
        Ok(columns)
    }

    fn value(&self, cell: &str) -> f64 {
        number(cell.trim(), self.decimal).or_else(|| iso_seconds(cell.trim())).unwrap_or(f64::NAN)
    }

    /// The numbers of the column at `at`.
    fn numbers(&self, at: usize) -> impl Iterator<Item = f64> {
        self.rows.iter().filter_map(move |row| number(row.get(at)?, self.decimal))
    }

    /// The texts of the column at `at`.
    pub fn texts(&self, at: usize) -> impl Iterator<Item = &str> {
        self.rows
            .iter()
            .filter_map(move |row| row.get(at).map(String::as_str))
            .filter(|cell| !cell.is_empty())
    }

    /// The largest modulus in the column at `at`, 0 if it has no numbers.
    pub(super) fn largest(&self, at: usize) -> f64 {
        self.numbers(at).fold(0.0, |most, number| most.max(number.abs()))
    }

    /// Whether the column at `at` has text and no numbers.
    pub(super) fn is_text(&self, at: usize) -> bool {
        self.numbers(at).next().is_none()
    }

    /// Whether the column at `at` has times such as `2024-05-01T12:00:00Z`.
    pub(super) fn has_iso_times(&self, at: usize) -> bool {
        let is_time = |cell: &str| iso_seconds(cell).is_some();
        self.texts(at).next().is_some() && self.texts(at).all(is_time)
    }

    /// Whether the numbers in the column at `at` increase from row to row.
    pub(super) fn increases(&self, at: usize) -> bool {
        let numbers: Vec<f64> = self.numbers(at).collect();
        numbers.len() > 2 && numbers.windows(2).all(|pair| pair[0] < pair[1])
    }

    /// The median difference between rows in the column at `at`, of times as text in seconds.
    pub(super) fn step(&self, at: usize) -> Option<f64> {
        let texts: Vec<f64> = self.texts(at).filter_map(iso_seconds).collect();
        let times: Vec<f64> = if texts.is_empty() { self.numbers(at).collect() } else { texts };
        let mut steps: Vec<f64> =
            times.windows(2).map(|pair| pair[1] - pair[0]).filter(|step| *step > 0.0).collect();
        steps.sort_by(f64::total_cmp);
        steps.get(steps.len() / 2).copied()
    }
}

fn cells(line: &str, separator: char) -> Vec<String> {
    let mut row = LineCells::default();
    row.split(line, separator);
    row.cells().map(|cell| cell.trim().to_owned()).collect()
}

fn refused(found: &str) -> LogError {
    let expected = "a header with a name for every column, or none, and rows below it";
    let remedy = "write ingest.toml yourself, with `header`, `columns` or `skip_lines` (docs/own-logs.md)";
    LogError::Invalid(Invalid::new("columns", found, expected, remedy))
}

fn number(cell: &str, decimal: char) -> Option<f64> {
    let plain = if decimal == ',' { cell.replace(',', ".") } else { cell.to_owned() };
    plain.parse().ok().filter(|number: &f64| number.is_finite())
}

/// Seconds of the day of a time such as `2024-05-01T12:00:00.5Z`: enough for the step between rows.
fn iso_seconds(cell: &str) -> Option<f64> {
    let (date, time) = cell.split_once(['T', ' '])?;
    let is_date = date.len() == 10
        && date.split('-').count() == 3
        && date.split('-').all(|part| part.parse::<u32>().is_ok());
    let time = time.split(['Z', '+']).next()?;
    let parts: Vec<f64> = time.split(':').map(|part| part.parse().ok()).collect::<Option<_>>()?;
    match (is_date, parts.as_slice()) {
        (true, [hours, minutes, seconds]) => Some(3600.0 * hours + 60.0 * minutes + seconds),
        _ => None,
    }
}
