//! Positions as CSV.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::io::BufRead;

use jiff::Timestamp;
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

/// What may stand between cells. A comma stands before decimals where it is another one.
const SEPARATORS: [char; 4] = [',', ';', '\t', '|'];

/// Reads the positions of CSV with a header, and the `inputs` of the vessel that it has. A last line without its end is left out if
/// cells are missing: the logger is still writing it.
pub(super) fn positions_in_table(bytes: impl BufRead, inputs: &[&str]) -> Result<LoggedPositions, LogError> {
    let (mut lines, mut row) = (Lines::new(bytes)?, Row::default());
    let first = lines.next()?.unwrap_or_default().to_owned();
    let mut is_separator = |separator: &char| {
        row.split(&first, *separator);
        row.cells().any(|cell| cell.trim() == COLUMNS[1])
    };
    let separator = SEPARATORS.into_iter().find(&mut is_separator).unwrap_or(',');
    row.split(&first, separator);
    let header: Vec<String> = row.cells().map(|cell| cell.trim().to_owned()).collect();
    let (width, stamps) = (header.len(), Stamps::new(&utc())?);
    let reader = Reader { places: places(&header, inputs)?, width, separator, stamps };
    let own = |name: &&&str| header.iter().position(|own| own == **name);
    let columns: Vec<(usize, &str)> = inputs.iter().filter_map(|name| Some((own(&name)?, *name))).collect();
    let (mut since, mut rows, mut logged) = (None, Vec::new(), BTreeMap::<String, Vec<[f64; 2]>>::new());
    while let Some(line) = lines.next()? {
        if line.trim().is_empty() {
            continue;
        }
        row.split(line, separator);
        if row.cells.len() < reader.width && !lines.is_ended {
            break;
        }
        let (own_since, position) = reader.position(&row, lines.number)?;
        let first = *since.get_or_insert(own_since);
        if own_since != first {
            return Err(mixed(lines.number, first).into());
        }
        for (place, name) in &columns {
            let cell = reader.decimal(row.cell(*place).trim());
            if !cell.is_empty() {
                let number = cell.parse().ok().filter(|number: &f64| number.is_finite());
                let number = number.ok_or_else(|| not_finite(lines.number, name, &cell))?;
                logged.entry((*name).to_owned()).or_default().push([position.at_s, number]);
            }
        }
        push(&mut rows, position)?;
    }
    let expected = "at least one row below the header";
    let positions = checked(since.unwrap_or(Since::Departure), rows, (f64::NEG_INFINITY, 0), expected)?;
    Ok(LoggedPositions { inputs: logged, ..positions })
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

/// The places of [`COLUMNS`] in the header; refuses others but the vessel's `inputs`, which would be ignored.
fn places(header: &[String], inputs: &[&str]) -> Result<[Option<usize>; 5], Invalid> {
    let thing = |name: &str| format!("line 1, column `{}`", foreign(name));
    for (place, name) in header.iter().enumerate() {
        if !name.is_empty() && !COLUMNS.iter().chain(inputs).any(|own| own == name) {
            let known = COLUMNS.into_iter().chain(inputs.iter().copied());
            return Err(Invalid::unknown(thing(name), &foreign(name), known));
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
    separator: char,
    stamps: Stamps,
}

impl Reader {
    /// The position in `row`, and what its time counts from.
    fn position(&self, row: &Row, line: usize) -> Result<(Since, LoggedPosition), Invalid> {
        let found = row.cells.len();
        if found != self.width {
            let expected = format!("{}, as in the header", self.width);
            let is_decimal = self.separator == ',' && found > self.width;
            let remedy = match is_decimal {
                true => "correct the line; numbers with decimal commas need semicolons between cells",
                false => "correct the line",
            };
            return Err(Invalid::new(format!("line {line}"), format!("{found} cells"), expected, remedy));
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
        if let Ok(number) = self.decimal(text).parse::<f64>() {
            let unix = [1.0, 1e3, 1e6, 1e9].map(|per_s| number / per_s).into_iter();
            let unix = unix
                .filter(|unix| (1e9..1e10).contains(unix))
                .find_map(|own| Timestamp::from_second(own as i64).ok());
            if let Some(date) = unix {
                let found = format!("`{}`, as of {date} counted from 1970", foreign(text));
                let expected = "seconds since the departure, or a date and time";
                let remedy = format!("write it as {date}, and so all times");
                return Err(Invalid::new(cell_of(line, COLUMNS[0]), found, expected, remedy));
            }
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
        let number = self.decimal(text).parse().ok().filter(|number: &f64| (least..=most).contains(number));
        number.map(Some).ok_or_else(|| out_of_range(line, column, text))
    }

    /// A number with a decimal point.
    fn decimal<'a>(&self, text: &'a str) -> Cow<'a, str> {
        if self.separator == ',' { text.into() } else { text.replace(',', ".").into() }
    }

    fn cell<'a>(&self, row: &'a Row, column: usize) -> &'a str {
        self.places[column].map_or("", |place| row.cell(place).trim())
    }
}

fn out_of_range(line: usize, column: usize, text: &str) -> Invalid {
    let [least, most] = RANGES[column];
    let expected = format!("a number from {least} to {most}");
    let found = format!("`{}`", foreign(text));
    let is_longitude = column == 2 && text.parse().is_ok_and(|number: f64| number.abs() <= 180.0);
    let remedy = match is_longitude {
        true => "exchange longitude and latitude if the columns are so named, or correct the cell",
        false => "correct the cell, or leave out the line",
    };
    Invalid::new(cell_of(line, COLUMNS[column]), found, expected, remedy)
}

fn not_finite(line: usize, name: &str, text: &str) -> Invalid {
    let found = format!("`{}`", foreign(text));
    Invalid::new(cell_of(line, name), found, "a number", "correct the cell, or leave it empty")
}
