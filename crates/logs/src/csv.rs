//! Logs as CSV: the requested columns.
//!
//! A row is a line: an unclosed quote spoils its own row and not the rest of the file, line numbers are those of an editor,
//! and blank lines are counted. Hence no general CSV reader: its rows extend over lines and it silently skips blank ones.

use std::io::BufRead;
use std::sync::Arc;

use refusal::{Invalid, foreign};

use crate::columns::{Cells, Columns, Content, WantedColumn, cell_of, is_nothing, places};
use crate::encoding::Lines;
use crate::{FileSpec, LogError, Moments, Plan, Store};

/// Separators to suggest for a file that does not use the declared one.
const SEPARATORS: [char; 4] = [';', '\t', ',', '|'];

/// Rows after which the usual length of a row is known.
const TYPICAL: usize = 1024;

/// Reads the columns of CSV with a header that `plan` wants of files of group `group`; `store` takes blocks of numbers.
/// Where the text's `length` in bytes is known, too many rows are refused before all of them are read.
///
/// # Errors
/// Bytes that cannot be read or are not text, missing columns (all at once), a cell that is not a number, a
/// row that is too long or too short. A last row that is too short is left out and counted.
pub fn read_csv<'a>(
    bytes: impl BufRead + 'a,
    length: Option<u64>,
    plan: &Plan,
    group: usize,
    store: Option<&Arc<dyn Store>>,
) -> Result<Columns, LogError> {
    let mut lines = Lines::new(bytes)?;
    let mut row = LineCells::default();
    let mut reading =
        TableReading::new(plan, group, store, header(&plan.setup.files[group], &mut lines, &mut row)?)?;
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

/// The state of reading.
struct TableReading<'a> {
    plan: &'a Plan,
    spec: &'a FileSpec,
    wanted: Vec<WantedColumn>,
    header: Vec<String>,
    /// Number of columns, without unnamed ones at the end.
    named: usize,
    /// Indices of the wanted columns.
    places: Vec<usize>,
    columns: Columns,
    moments: Moments<'a>,
    /// Whether decimals of the time are counted.
    has_fractions: bool,
    /// The refusal of a row that is too short, unless it turns out to be the last.
    short: Option<Invalid>,
    ends: Ends,
}

impl<'a> TableReading<'a> {
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

    /// Takes the row on `line`, which is unfinished unless `is_ended`.
    fn take(&mut self, row: &LineCells, line: usize, is_ended: bool) -> Result<(), LogError> {
        if let Some(short) = self.short.take() {
            return Err(LogError::Invalid(short));
        }
        let (cells, most) = (row.cells.len(), self.plan.most_rows);
        let is_blank = |cell: &str| cell.trim().is_empty();
        // An empty cell after the last column does not count.
        let fits = cells == self.header.len()
            || cells >= self.named && row.cells().skip(self.header.len()).all(is_blank);
        if row.cells().all(is_blank) || self.is_header(row) {
            self.columns.empty_rows += 1;
        } else if fits && !is_ended && self.ends.is_cut(row) {
            self.columns.cut_rows += 1;
        } else if fits {
            self.ends.see(row);
            self.cells(row, line)?;
        } else if cells < self.named {
            self.short = Some(self.wrong_width(row, line));
        } else {
            return Err(LogError::Invalid(self.wrong_width(row, line)));
        }
        if self.columns.lines.rows() > most || self.columns.empty_rows > most.max(TYPICAL) {
            return Err(LogError::Invalid(self.plan.too_many_rows(line)));
        }
        Ok(())
    }

    /// Whether a row repeats the header, as where a logger was restarted.
    fn is_header(&self, row: &LineCells) -> bool {
        let is = |(cell, name): (&str, &String)| cell.trim() == name;
        self.spec.header && row.cells.len() == self.header.len() && row.cells().zip(&self.header).all(is)
    }

    fn cells(&mut self, row: &LineCells, line: usize) -> Result<(), LogError> {
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

    fn wrong_width(&self, row: &LineCells, line: usize) -> Invalid {
        let (cells, expected) = (row.cells.len(), self.header.len());
        let is_whole = |cell: &str| cell.trim().bytes().all(|b| b.is_ascii_digit() || b"+-".contains(&b));
        let has_commas = self.spec.separator == ','
            && cells > expected
            && cells <= 2 * expected
            && row.cells().all(is_whole);
        let remedy = if has_commas {
            " (decimal commas: export with decimal points, or another separator)"
        } else if cells > expected {
            " (a cell that holds the separator stands in quotes)"
        } else {
            ""
        };
        let (as_in, columns) =
            if self.spec.header { ("in the header", "") } else { ("`columns` says", ", `columns`") };
        Invalid::new(
            format!("line {line}"),
            format!("{cells} cells"),
            format!("{expected}, as {as_in}"),
            format!("correct the line, or `separator`{columns} in {}{remedy}", self.plan.setup.written_in),
        )
    }
}

/// The names of the columns: those of the header, or their numbers where there is none.
fn header(spec: &FileSpec, lines: &mut Lines, row: &mut LineCells) -> Result<Vec<String>, LogError> {
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

/// Appends a number or a label; `None` where the cell is not what its column holds.
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
        // A point between thousands would be read as the decimal one.
        _ if cell.contains('.') => None,
        _ => cell.replacen(decimal, ".", 1).parse().ok(),
    };
    parsed.or_else(|| is_nothing(cell).then_some(f64::NAN))
}

/// The refusal where columns are missing because the header, a single cell, uses another separator.
fn other_separator(header: &[String], expected: char, written_in: &str) -> Option<Invalid> {
    let [only] = header else { return None };
    let separator = SEPARATORS.into_iter().find(|c| *c != expected && only.contains(*c))?;
    Some(Invalid::new(
        "line 1",
        format!("{} cells separated by {separator:?}", only.matches(separator).count() + 1),
        format!("cells separated by {expected:?}"),
        format!("set `separator = {:?}` in {written_in}", separator.to_string()),
    ))
}

/// The cells of a line. Reused for every line, so that none is allocated.
#[derive(Default)]
pub(crate) struct LineCells {
    /// The line; for a line with quotes, the texts of its cells.
    text: String,
    /// Where each cell begins and ends.
    pub(crate) cells: Vec<[usize; 2]>,
}

impl LineCells {
    /// The separator is an ASCII character; a blank stands for any number of blanks.
    pub(crate) fn split(&mut self, line: &str, separator: char) {
        self.text.clear();
        self.cells.clear();
        if separator == ' ' {
            let place = |cell: &str| cell.as_ptr().addr() - line.as_ptr().addr();
            self.cells.extend(line.split_ascii_whitespace().map(|c| [place(c), place(c) + c.len()]));
        } else if line.contains('"') {
            return self.split_quoted(line, separator);
        } else {
            let mut start = 0;
            for (at, _) in line.bytes().enumerate().filter(|(_, byte)| char::from(*byte) == separator) {
                self.cells.push([start, at]);
                start = at + 1;
            }
            self.cells.push([start, line.len()]);
        }
        self.text.push_str(line);
    }

    /// A quoted cell may contain the separator, and doubled quotes.
    fn split_quoted(&mut self, line: &str, separator: char) {
        let (mut quoted, mut start) = (false, 0);
        let mut characters = line.chars().peekable();
        while let Some(c) = characters.next() {
            match c {
                '"' if quoted && characters.next_if_eq(&'"').is_some() => self.text.push('"'),
                '"' => quoted = !quoted,
                c if c == separator && !quoted => {
                    self.cells.push([start, self.text.len()]);
                    start = self.text.len();
                }
                c => self.text.push(c),
            }
        }
        self.cells.push([start, self.text.len()]);
    }

    pub(crate) fn cell(&self, place: usize) -> &str {
        let [start, end] = self.cells[place];
        &self.text[start..end]
    }

    pub(crate) fn cells(&self) -> impl Iterator<Item = &str> {
        (0..self.cells.len()).map(|place| self.cell(place))
    }
}

/// What the last cells of rows look like: a cut one has fewer decimals, or is shorter, than all before it.
struct Ends {
    decimals: usize,
    length: usize,
}

impl Default for Ends {
    fn default() -> Self {
        Self { decimals: usize::MAX, length: usize::MAX }
    }
}

impl Ends {
    fn of(row: &LineCells) -> Self {
        let cell = row.cells.last().map_or("", |[start, end]| row.text[*start..*end].trim());
        Self { decimals: cell.rfind(['.', ',']).map_or(0, |point| cell.len() - point), length: cell.len() }
    }

    pub(crate) fn see(&mut self, row: &LineCells) {
        let Self { decimals, length } = Self::of(row);
        (self.decimals, self.length) = (self.decimals.min(decimals), self.length.min(length));
    }

    pub(crate) fn is_cut(&self, row: &LineCells) -> bool {
        let ends = Self::of(row);
        self.decimals != usize::MAX
            && (ends.decimals < self.decimals || self.decimals == 0 && ends.length < self.length)
    }
}
