//! Logs as CSV: the columns that are asked for.
//!
//! A row is a line: a quote that nobody closes spoils its own row and not the rest of the file, lines have the numbers that
//! an editor shows, and blank lines are counted. Hence no general reader of CSV, whose rows go on over lines and which
//! passes over blank ones in silence.

use std::io::{BufRead, Read};
use std::sync::Arc;

use refusal::Invalid;

use crate::columns::{Cells, Columns, Content, cell_of, places};
use crate::{FileSpec, LogError, NoStamp, Plan, Stamps, Store};

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
) -> Result<Columns, LogError> {
    let (wanted, spec, stamps) = (plan.wanted(group), &plan.setup.files[group], plan.stamps(group));
    let (separator, written_in) = (spec.separator, plan.setup.written_in);
    let mut lines = Lines::new(bytes);
    let mut row = Row::default();
    let header = header(spec, &mut lines, &mut row)?;
    let places = places(&header, &wanted)
        .map_err(|missing| other_separator(&header, separator, written_in).unwrap_or(missing))?;
    let cells = wanted.iter().map(|w| Cells::none(w.content, store)).collect();
    let mut columns = Columns { cells, ..Columns::default() };
    let mut short = None;
    while let Some(line) = lines.next()? {
        if let Some(short) = short {
            return Err(LogError::Invalid(short));
        }
        row.split(line, separator);
        let (line, found, expected) = (lines.number, row.cells.len(), header.len());
        if row.cells().all(|cell| cell.trim().is_empty()) {
            columns.empty_rows += 1;
        } else if found == expected {
            if columns.lines.rows() >= plan.most_rows {
                return Err(LogError::Invalid(plan.too_many_rows(line)));
            }
            if let (Some(length), TYPICAL) = (length, columns.lines.rows()) {
                let rows = (TYPICAL as f64 * length as f64 / lines.read as f64) as usize;
                if rows / 2 > plan.most_rows {
                    return Err(LogError::Invalid(plan.too_many_rows(format_args!("about {rows}"))));
                }
            }
            columns.lines.push(line);
            for ((cells, place), wanted) in columns.cells.iter_mut().zip(&places).zip(&wanted) {
                let (cell, column) = (row.cell(*place).trim(), &header[*place]);
                match wanted.content {
                    Content::Dates => push_date(cells, stamps, cell)
                        .map_err(|why| stamps.refused(line, column, cell, why, written_in))?,
                    _ => push(cells, spec.decimal, cell)
                        .ok_or_else(|| no_number(line, column, cell, spec.decimal, written_in))?,
                }
            }
        } else if found < expected {
            short = Some(wrong_width(line, found, header.len(), spec, written_in));
        } else {
            return Err(LogError::Invalid(wrong_width(line, found, header.len(), spec, written_in)));
        }
    }
    columns.cut_rows = usize::from(short.is_some());
    Ok(columns)
}

/// The names of the columns: those of the header, or their numbers where there is none.
fn header<B: BufRead>(spec: &FileSpec, lines: &mut Lines<B>, row: &mut Row) -> Result<Vec<String>, LogError> {
    for _ in 0..spec.skip_lines {
        lines.next()?;
    }
    if !spec.header {
        return Ok((1..=spec.columns.unwrap_or(0)).map(|number| number.to_string()).collect());
    }
    row.split(lines.next()?.unwrap_or_default().trim_start_matches('\u{feff}'), spec.separator);
    Ok(row.cells().map(|cell| cell.trim().to_owned()).collect())
}

fn wrong_width(line: usize, found: usize, expected: usize, spec: &FileSpec, written_in: &str) -> Invalid {
    let comma = found > expected && spec.separator == ',';
    let comma =
        if comma { " (decimal commas: export with decimal points, or another separator)" } else { "" };
    let (as_in, columns) =
        if spec.header { ("in the header", "") } else { ("`columns` says", ", `columns`") };
    Invalid::new(
        format!("line {line}"),
        format!("{found} cells"),
        format!("{expected}, as {as_in}"),
        format!("correct the line, or `separator`{columns} in {written_in}{comma}"),
    )
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
    Invalid::new(cell_of(line, column), format!("`{found}`"), expected, remedy)
}

/// The lines of a text, one at a time.
pub(crate) struct Lines<B> {
    bytes: B,
    line: Vec<u8>,
    /// Number of the line, from 1.
    number: usize,
    /// Bytes of all lines so far.
    read: u64,
}

impl<B: BufRead> Lines<B> {
    pub(crate) fn new(bytes: B) -> Self {
        Self { bytes, line: Vec::new(), number: 0, read: 0 }
    }

    /// The next line, without its end.
    fn next(&mut self) -> Result<Option<&str>, LogError> {
        let Some((number, line)) = self.bytes()? else { return Ok(None) };
        std::str::from_utf8(line).map(Some).map_err(|_| {
            let found = format!("a byte that is not UTF-8 (line {number})");
            LogError::Invalid(Invalid::new("text", found, "UTF-8 text", "save the file as UTF-8"))
        })
    }

    /// The number of the next line, from 1, and its bytes, without its end.
    pub(crate) fn bytes(&mut self) -> Result<Option<(usize, &[u8])>, LogError> {
        self.line.clear();
        if (&mut self.bytes).take(LONGEST_LINE).read_until(b'\n', &mut self.line)? == 0 {
            return Ok(None);
        }
        self.number += 1;
        self.read += self.line.len() as u64;
        if self.line.len() as u64 == LONGEST_LINE {
            return Err(LogError::Invalid(Invalid::new(
                format!("line {}", self.number),
                format!("{LONGEST_LINE} bytes without an end of the line"),
                "a row of cells",
                "correct or leave out the file: it is damaged, or no CSV",
            )));
        }
        let line = self.line.strip_suffix(b"\n").unwrap_or(&self.line);
        Ok(Some((self.number, line.strip_suffix(b"\r").unwrap_or(line))))
    }
}

/// The cells of a line. Used again for every line, so that no line is allocated.
#[derive(Default)]
struct Row {
    /// The line; of one with quotes, the cells' texts.
    text: String,
    /// Where each cell begins and ends.
    cells: Vec<[usize; 2]>,
}

impl Row {
    /// The separator is an ASCII character; a blank stands for any number of them.
    fn split(&mut self, line: &str, separator: char) {
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

    /// A cell in quotes may contain the separator, and quotes written twice.
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

    fn cell(&self, place: usize) -> &str {
        let [start, end] = self.cells[place];
        &self.text[start..end]
    }

    fn cells(&self) -> impl Iterator<Item = &str> {
        (0..self.cells.len()).map(|place| self.cell(place))
    }
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
    parsed.or_else(|| NOTHING.contains(&cell.to_ascii_lowercase().as_str()).then_some(f64::NAN))
}

fn push_date(cells: &mut Cells, stamps: &Stamps, cell: &str) -> Result<(), NoStamp> {
    if let Cells::Numbers(numbers) = cells {
        numbers.push(stamps.seconds(cell)?);
    }
    Ok(())
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
