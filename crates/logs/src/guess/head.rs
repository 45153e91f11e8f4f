//! The first rows of a log in columns.

use refusal::{Invalid, foreign};

/// Separators that are tried, the likeliest first.
const SEPARATORS: [char; 4] = [',', ';', '\t', '|'];

/// Rows that are looked at.
const ROWS: usize = 400;

/// The columns of a log and its first rows.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Head {
    /// What stands between cells.
    pub separator: char,
    /// What stands before the decimals.
    pub decimal: char,
    /// Names of the columns.
    pub columns: Vec<String>,
    /// Rows of cells.
    rows: Vec<Vec<String>>,
}

impl Head {
    /// The columns and rows of `text`, the beginning of a file; its last line may be cut off.
    ///
    /// # Errors
    /// No separator, no header, no row of numbers below it.
    pub fn of_csv(text: &str) -> Result<Self, Invalid> {
        let mut lines: Vec<&str> = text.lines().filter(|line| !line.trim().is_empty()).take(ROWS).collect();
        if lines.len() > 2 {
            lines.pop();
        }
        let Some((first, below)) = lines.split_first().filter(|(_, below)| !below.is_empty()) else {
            return Err(refused("fewer than two lines"));
        };
        let width = |line: &str, separator: char| line.split(separator).count();
        let fits = |separator: &char| {
            width(first, *separator) > 1
                && below.iter().all(|line| width(line, *separator) == width(first, *separator))
        };
        // A comma may stand before decimals, too.
        let found = [';', '\t', '|', ',']
            .into_iter()
            .find(fits)
            .or(SEPARATORS.into_iter().find(|c| width(first, *c) > 1));
        let Some(separator) = found else { return Err(refused("a first line without separators")) };
        let cells =
            |line: &str| line.split(separator).map(|cell| cell.trim().trim_matches('"').to_owned()).collect();
        let columns: Vec<String> = cells(first);
        let rows: Vec<Vec<String>> = below.iter().map(|line| cells(line)).collect();
        let has_comma = separator != ','
            && rows.iter().flatten().any(|cell| number(cell, ',').is_some() && cell.contains(','));
        let head = Self { separator, decimal: if has_comma { ',' } else { '.' }, columns, rows };
        match head.columns.iter().find(|name| name.is_empty() || number(name, head.decimal).is_some()) {
            Some(wrong) => Err(refused(&format!("`{}` in the first line", foreign(wrong)))),
            None => Ok(head),
        }
    }

    /// The columns of a table that is not text: their names, and the first cells of each as text.
    pub fn of_cells(columns: Vec<String>, cells: &[Vec<String>]) -> Self {
        let rows = cells.iter().map(Vec::len).max().unwrap_or(0);
        let row = |at: usize| cells.iter().map(|own| own.get(at).cloned().unwrap_or_default()).collect();
        Self { separator: ',', decimal: '.', columns, rows: (0..rows.min(ROWS)).map(row).collect() }
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

fn refused(found: &str) -> Invalid {
    let expected = "a header with a name for every column, and rows below it";
    let remedy = "write ingest.toml yourself, with `header`, `columns` or `skip_lines` (docs/own-logs.md)";
    Invalid::new("columns", found, expected, remedy)
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
