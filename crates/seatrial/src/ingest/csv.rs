//! CSV files as text: the columns that are asked for.

use std::fs::File;
use std::io::{BufRead, BufReader, Read};
use std::path::Path;

use flate2::read::MultiGzDecoder;

use super::load::{Cells, Raw, Wanted, missing_columns};
use crate::failure::Failure;

/// What stands for no value.
const NOTHING: [&str; 8] = ["", "nan", "na", "n/a", "null", "inf", "+inf", "-inf"];

/// What separates cells in files that do not separate them as ingest.toml says.
const SEPARATORS: [char; 4] = [';', '\t', ',', '|'];

/// Reads the `wanted` columns of a CSV file with a header, compressed where its name ends in `.gz`.
///
/// # Errors
/// A file that cannot be read or is cut short, missing columns (all at once), a cell that is no number, a row that is too
/// long or too short. The last row may be too short: then it is left out and counted.
pub fn read(path: &Path, separator: char, wanted: &[Wanted]) -> Result<Raw, Failure> {
    let mut lines = Lines::open(path)?;
    let mut row = Row::default();
    let first = lines.next()?.unwrap_or_default();
    row.split(first.trim_start_matches('\u{feff}'), separator);
    let header: Vec<String> = row.cells().map(|cell| cell.trim().to_owned()).collect();
    let places = places(path, separator, &header, wanted)?;
    let mut raw = Raw::new(wanted);
    let mut short = None;
    while let Some(line) = lines.next()? {
        row.split(line, separator);
        let number = lines.number;
        if let Some((line, cells)) = short {
            return Err(wrong_width(path, line, cells, header.len()));
        }
        if row.cells().all(|cell| cell.trim().is_empty()) {
            raw.empty_rows += 1;
        } else if row.len() == header.len() {
            raw.lines.push(number);
            for (column, place) in raw.columns.iter_mut().zip(&places) {
                push(column, row.cell(*place))
                    .map_err(|found| no_number(path, number, &header[*place], &found))?;
            }
        } else if row.len() < header.len() {
            short = Some((number, row.len()));
        } else {
            return Err(wrong_width(path, number, row.len(), header.len()));
        }
    }
    raw.cut_rows = usize::from(short.is_some());
    Ok(raw)
}

fn wrong_width(path: &Path, line: usize, found: usize, expected: usize) -> Failure {
    let comma = if found > expected { " (decimal commas: export with decimal points)" } else { "" };
    Failure::refuse(
        path,
        &format!("line {line}"),
        &format!("{found} cells"),
        &format!("{expected}, as in the header"),
        &format!("correct the line, or `separator` in ingest.toml{comma}"),
    )
}

/// The lines of a file, one at a time.
struct Lines<'a> {
    path: &'a Path,
    reader: Box<dyn BufRead>,
    line: Vec<u8>,
    /// Number of the line, from 1.
    number: usize,
}

impl<'a> Lines<'a> {
    fn open(path: &'a Path) -> Result<Self, Failure> {
        const BUFFER: usize = 1 << 18;
        let file = File::open(path).map_err(|e| artifact::Error::io(path, "read", e))?;
        let reader: Box<dyn Read> = match path.extension() {
            Some(extension) if extension == "gz" => Box::new(MultiGzDecoder::new(file)),
            _ => Box::new(file),
        };
        let reader = Box::new(BufReader::with_capacity(BUFFER, reader));
        Ok(Self { path, reader, line: Vec::new(), number: 0 })
    }

    /// The next line, without its end.
    fn next(&mut self) -> Result<Option<&str>, Failure> {
        self.line.clear();
        let read = self.reader.read_until(b'\n', &mut self.line).map_err(|e| damaged(self.path, e))?;
        if read == 0 {
            return Ok(None);
        }
        self.number += 1;
        let line = self.line.strip_suffix(b"\n").unwrap_or(&self.line);
        let line = line.strip_suffix(b"\r").unwrap_or(line);
        std::str::from_utf8(line).map(Some).map_err(|_| {
            let found = format!("a byte that is not UTF-8 (line {})", self.number);
            Failure::refuse(self.path, "text", &found, "UTF-8 text", "save the file as UTF-8")
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
        let mut quoted = false;
        let quotes = line.contains('"');
        if !quotes {
            for cell in line.split(separator) {
                self.text.push_str(cell);
                self.ends.push(self.text.len());
            }
            return;
        }
        let mut characters = line.chars().peekable();
        while let Some(c) = characters.next() {
            match c {
                '"' if quoted && characters.peek() == Some(&'"') => {
                    characters.next();
                    self.text.push('"');
                }
                '"' => quoted = !quoted,
                c if c == separator && !quoted => self.ends.push(self.text.len()),
                c => self.text.push(c),
            }
        }
        self.ends.push(self.text.len());
    }

    fn len(&self) -> usize {
        self.ends.len()
    }

    fn cell(&self, place: usize) -> &str {
        let start = if place == 0 { 0 } else { self.ends[place - 1] };
        &self.text[start..self.ends[place]]
    }

    fn cells(&self) -> impl Iterator<Item = &str> {
        (0..self.len()).map(|place| self.cell(place))
    }
}

fn push(cells: &mut Cells, cell: &str) -> Result<(), String> {
    let cell = cell.trim();
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

fn no_number(path: &Path, line: usize, column: &str, found: &str) -> Failure {
    let comma = found.replacen(',', ".", 1).parse::<f64>().is_ok();
    let remedy = if comma { "export with decimal points" } else { "correct the cell or leave it empty" };
    Failure::refuse(
        path,
        &format!("line {line}, column `{column}`"),
        &format!("`{found}`"),
        "a number",
        remedy,
    )
}

fn places(path: &Path, separator: char, header: &[String], wanted: &[Wanted]) -> Result<Vec<usize>, Failure> {
    let place = |wanted: &Wanted| header.iter().position(|column| *column == wanted.column);
    let places: Vec<Option<usize>> = wanted.iter().map(place).collect();
    if places.contains(&None) {
        return Err(separated_otherwise(path, separator, header)
            .unwrap_or_else(|| missing_columns(path, header, wanted)));
    }
    Ok(places.into_iter().flatten().collect())
}

/// Where the whole header is one cell in which another separator stands.
fn separated_otherwise(path: &Path, separator: char, header: &[String]) -> Option<Failure> {
    let [only] = header else { return None };
    let other = SEPARATORS.into_iter().find(|other| *other != separator && only.contains(*other))?;
    let count = only.matches(other).count() + 1;
    Some(Failure::refuse(
        path,
        "line 1",
        &format!("{count} cells separated by {other:?}"),
        &format!("cells separated by {separator:?}"),
        &format!("set `separator = {:?}` in ingest.toml", other.to_string()),
    ))
}

fn damaged(path: &Path, error: std::io::Error) -> Failure {
    use std::io::ErrorKind::{InvalidData, InvalidInput, UnexpectedEof};
    let found = match error.kind() {
        UnexpectedEof => "an end within the compressed data".to_owned(),
        InvalidData | InvalidInput => error.to_string(),
        _ => return artifact::Error::io(path, "read", error).into(),
    };
    Failure::refuse(
        path,
        "file",
        &found,
        "a whole gzip file",
        "the file is truncated or damaged: copy it again",
    )
}
