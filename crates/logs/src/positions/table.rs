//! Positions as CSV.

use std::io::BufRead;

use refusal::{Invalid, foreign};

use crate::columns::cell_of;
use crate::lines::Lines;
use crate::position::{LoggedPosition, LoggedPositions, Since, checked, push};
use crate::row::Row;
use crate::{LogError, Stamps, TimeSpec};

/// The columns: three that are needed, and two that may be left out.
const COLUMNS: [&str; 5] = ["time", "longitude_deg", "latitude_deg", "heading_deg", "speed_m_s"];
const NEEDED: usize = 3;
/// Their least and greatest values; of times in seconds, too.
const RANGES: [[f64; 2]; 5] = [[-1e9, 1e9], [-180.0, 180.0], [-89.0, 89.0], [0.0, 360.0], [0.0, 100.0]];

/// Reads the positions of CSV with a header. A last line without its end is left out if cells are missing: the logger is
/// still writing it.
pub(super) fn positions_in_table(bytes: impl BufRead) -> Result<LoggedPositions, LogError> {
    let (mut lines, mut row) = (Lines::new(bytes)?, Row::default());
    row.split(lines.next()?.unwrap_or_default(), ',');
    let header: Vec<String> = row.cells().map(|cell| cell.trim().to_owned()).collect();
    let reader = Reader { places: places(&header)?, width: header.len(), stamps: Stamps::new(&utc())? };
    let (mut since, mut rows) = (None, Vec::new());
    while let Some(line) = lines.next()? {
        if line.trim().is_empty() {
            continue;
        }
        row.split(line, ',');
        if row.cells.len() < reader.width && !lines.is_ended {
            break;
        }
        let (own_since, position) = reader.position(&row, lines.number)?;
        let first = *since.get_or_insert(own_since);
        if own_since != first {
            return Err(mixed(lines.number, first).into());
        }
        push(&mut rows, position)?;
    }
    checked(since.unwrap_or(Since::Departure), rows, "at least one row below the header")
}

/// Times with an offset, or in UTC.
fn utc() -> TimeSpec {
    let (unit, format, zone, nanoseconds) = (None, None, None, None);
    TimeSpec {
        column: COLUMNS[0].to_owned(),
        unit,
        format,
        zone,
        nanoseconds,
        repeated: Default::default(),
        offset_s: 0.0,
    }
}

/// The places of [`COLUMNS`] in the header; refuses others, which would be ignored.
fn places(header: &[String]) -> Result<[Option<usize>; 5], Invalid> {
    let thing = |name: &str| format!("line 1, column `{}`", foreign(name));
    for (place, name) in header.iter().enumerate() {
        if !name.is_empty() && !COLUMNS.contains(&name.as_str()) {
            return Err(Invalid::unknown(thing(name), &foreign(name), COLUMNS));
        }
        if !name.is_empty() && header[..place].contains(name) {
            return Err(Invalid::new(thing(name), "it twice", "every column once", "remove one"));
        }
    }
    let places = COLUMNS.map(|name| header.iter().position(|own| own == name));
    match places[..NEEDED].iter().position(Option::is_none) {
        Some(missing) => {
            let expected = "time, longitude_deg, latitude_deg, and heading_deg, speed_m_s if they are known";
            let remedy = "name the columns so in the first line";
            Err(Invalid::new(thing(COLUMNS[missing]), "none", expected, remedy))
        }
        None => Ok(places),
    }
}

/// The refusal of a time of another kind than the first.
fn mixed(line: usize, first: Since) -> Invalid {
    let [seconds, date] = ["seconds since the departure", "a date and time"];
    let (found, expected) = if first == Since::Epoch { (seconds, date) } else { (date, seconds) };
    let expected = format!("{expected}, as in the first row");
    Invalid::new(cell_of(line, COLUMNS[0]), found, expected, "write all times in one way")
}

/// What rows are read with.
struct Reader {
    places: [Option<usize>; 5],
    /// Cells of a row.
    width: usize,
    stamps: Stamps,
}

impl Reader {
    /// The position in `row`, and what its time counts from.
    fn position(&self, row: &Row, line: usize) -> Result<(Since, LoggedPosition), Invalid> {
        let found = row.cells.len();
        if found != self.width {
            let expected = format!("{}, as in the header", self.width);
            return Err(Invalid::new(
                format!("line {line}"),
                format!("{found} cells"),
                expected,
                "correct the line",
            ));
        }
        let (since, at_s) = self.time(row, line)?;
        let needed = |column: usize| {
            let value = self.number(row, line, column)?;
            value.ok_or_else(|| out_of_range(line, column, ""))
        };
        let (longitude_deg, latitude_deg) = (needed(1)?, needed(2)?);
        let heading_deg = self.number(row, line, 3)?;
        let speed_m_s = self.number(row, line, 4)?;
        Ok((since, LoggedPosition { line, at_s, longitude_deg, latitude_deg, heading_deg, speed_m_s }))
    }

    /// Seconds since the departure, or since 1970 for a date and time.
    fn time(&self, row: &Row, line: usize) -> Result<(Since, f64), Invalid> {
        let text = self.cell(row, 0);
        if text.parse::<f64>().is_ok() {
            let seconds = self.number(row, line, 0)?;
            return Ok((Since::Departure, seconds.ok_or_else(|| out_of_range(line, 0, text))?));
        }
        match self.stamps.seconds(text) {
            Ok(seconds) if seconds.is_finite() => Ok((Since::Epoch, seconds)),
            _ => Err(Invalid::new(
                cell_of(line, COLUMNS[0]),
                format!("`{}`", foreign(text)),
                "seconds since the departure, or a date and time such as 2026-06-01T08:00:00Z",
                "correct the cell",
            )),
        }
    }

    /// The number in a column; `None` where the column or its value is missing.
    fn number(&self, row: &Row, line: usize, column: usize) -> Result<Option<f64>, Invalid> {
        let text = self.cell(row, column);
        if text.is_empty() {
            return Ok(None);
        }
        let [least, most] = RANGES[column];
        let number = text.parse().ok().filter(|number: &f64| (least..=most).contains(number));
        number.map(Some).ok_or_else(|| out_of_range(line, column, text))
    }

    fn cell<'a>(&self, row: &'a Row, column: usize) -> &'a str {
        self.places[column].map_or("", |place| row.cell(place).trim())
    }
}

fn out_of_range(line: usize, column: usize, text: &str) -> Invalid {
    let [least, most] = RANGES[column];
    let expected = format!("a number from {least} to {most}");
    let found = format!("`{}`", foreign(text));
    Invalid::new(cell_of(line, COLUMNS[column]), found, expected, "correct the cell, or leave out the line")
}
