//! Positions of a ship under way, from a table or from sentences: when and where she was, and what she knew of her
//! heading and speed there.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::io::BufRead;

use jiff::Timestamp;
use refusal::{Invalid, foreign};

use crate::columns::cell_of;
use crate::csv::LineCells;
use crate::encoding::Lines;
use crate::nmea::fields::{FieldColumn, Value};
use crate::nmea::sentence::{Accepted, Checksum, Sentence, raw_sentences};
use crate::nmea::timeline::{DAY, is_dated, reported_time};
use crate::{Format, LogError, Stamps, TimeSpec};

/// Reads positions from CSV with the columns `time`, `longitude_deg`, `latitude_deg` and, if known, `heading_deg`,
/// `speed_m_s` and the `inputs` of the vessel; or from the sentences RMC, GGA, GNS or GLL of NMEA 0183, with headings from HDT and THS.
///
/// # Errors
/// Bytes that cannot be read, another format, columns that are missing or unknown, numbers out of range, times that do
/// not ascend, no position, positions that end before the log, two receivers.
pub fn read_positions(
    bytes: impl BufRead,
    format: Format,
    inputs: &[&str],
) -> Result<LoggedPositions, LogError> {
    match format {
        Format::Csv => positions_in_table(bytes, inputs),
        Format::Nmea => positions_in_sentences(bytes),
        Format::Parquet | Format::Mcap | Format::Bag | Format::Db3 | Format::Ulg => {
            let expected = "positions as CSV, or as NMEA 0183 in a file called .nmea";
            let remedy = "export longitude and latitude over time";
            Err(Invalid::new("format", "a table or a bag", expected, remedy).into())
        }
    }
}

/// The columns: three that are needed, and two that may be left out.
const COLUMNS: [&str; 5] = ["time", "longitude_deg", "latitude_deg", "heading_deg", "speed_m_s"];
const NEEDED: usize = 3;
/// Their least and greatest values; of times in seconds, too.
const RANGES: [[f64; 2]; 5] = [[-1e9, 1e9], [-180.0, 180.0], [-89.0, 89.0], [0.0, 360.0], [0.0, 100.0]];

/// What may stand between cells. A comma stands before decimals where it is another one.
const SEPARATORS: [char; 4] = [',', ';', '\t', '|'];

/// Reads the positions of CSV with a header, and the `inputs` of the vessel that it has. A last line without its end is left out if
/// cells are missing: the logger is still writing it.
fn positions_in_table(bytes: impl BufRead, inputs: &[&str]) -> Result<LoggedPositions, LogError> {
    let (mut lines, mut row) = (Lines::new(bytes)?, LineCells::default());
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
    let place = |name: &&&str| header.iter().position(|other| other == **name);
    let columns: Vec<(usize, &str)> = inputs.iter().filter_map(|name| Some((place(&name)?, *name))).collect();
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
        if !name.is_empty() && !COLUMNS.iter().chain(inputs).any(|other| other == name) {
            let known = COLUMNS.into_iter().chain(inputs.iter().copied());
            return Err(Invalid::unknown(thing(name), &foreign(name), known));
        }
        if !name.is_empty() && header[..place].contains(name) {
            return Err(Invalid::new(thing(name), "it twice", "every column once", "remove one"));
        }
    }
    let places = COLUMNS.map(|name| header.iter().position(|other| other == name));
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
    let (given, expected) = if first == Since::Epoch { (seconds, date) } else { (date, seconds) };
    let expected = format!("{expected}, as in the first row");
    Invalid::new(cell_of(line, COLUMNS[0]), given, expected, "write all times in one way")
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
    fn position(&self, row: &LineCells, line: usize) -> Result<(Since, LoggedPosition), Invalid> {
        let cells = row.cells.len();
        if cells != self.width {
            let expected = format!("{}, as in the header", self.width);
            let is_decimal = self.separator == ',' && cells > self.width;
            let remedy = match is_decimal {
                true => "correct the line; numbers with decimal commas need semicolons between cells",
                false => "correct the line",
            };
            return Err(Invalid::new(format!("line {line}"), format!("{cells} cells"), expected, remedy));
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
    fn time(&self, row: &LineCells, line: usize) -> Result<(Since, f64), Invalid> {
        let text = self.cell(row, 0);
        if let Ok(number) = self.decimal(text).parse::<f64>() {
            let unix = [1.0, 1e3, 1e6, 1e9].map(|per_s| number / per_s).into_iter();
            let unix = unix
                .filter(|unix| (1e9..1e10).contains(unix))
                .find_map(|seconds| Timestamp::from_second(seconds as i64).ok());
            if let Some(date) = unix {
                let dated = format!("`{}`, as of {date} counted from 1970", foreign(text));
                let expected = "seconds since the departure, or a date and time";
                let remedy = format!("write it as {date}, and so all times");
                return Err(Invalid::new(cell_of(line, COLUMNS[0]), dated, expected, remedy));
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
    fn number(&self, row: &LineCells, line: usize, column: usize) -> Result<Option<f64>, Invalid> {
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

    fn cell<'a>(&self, row: &'a LineCells, column: usize) -> &'a str {
        self.places[column].map_or("", |place| row.cell(place).trim())
    }
}

fn out_of_range(line: usize, column: usize, text: &str) -> Invalid {
    let [least, most] = RANGES[column];
    let expected = format!("a number from {least} to {most}");
    let quoted = format!("`{}`", foreign(text));
    let is_longitude = column == 2 && text.parse().is_ok_and(|number: f64| number.abs() <= 180.0);
    let remedy = match is_longitude {
        true => "exchange longitude and latitude if the columns are so named, or correct the cell",
        false => "correct the cell, or leave out the line",
    };
    Invalid::new(cell_of(line, COLUMNS[column]), quoted, expected, remedy)
}

fn not_finite(line: usize, name: &str, text: &str) -> Invalid {
    let quoted = format!("`{}`", foreign(text));
    Invalid::new(cell_of(line, name), quoted, "a number", "correct the cell, or leave it empty")
}

/// Most positions of a file: ten a second for a day.
const MOST: usize = 864_000;

/// A ship is elsewhere so long after her last position \[s\].
const STALE_S: f64 = 10.0;

/// A position of the ship.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LoggedPosition {
    /// The line that it stands on, from 1.
    pub line: usize,
    /// When she was there, since [`LoggedPositions::since`] \[s\].
    pub at_s: f64,
    /// Longitude, from −180 to 180 \[deg\].
    pub longitude_deg: f64,
    /// Latitude \[deg\].
    pub latitude_deg: f64,
    /// True heading, where it was logged \[deg\].
    pub heading_deg: Option<f64>,
    /// Speed over the ground, where it was logged \[m/s\].
    pub speed_m_s: Option<f64>,
}

/// What times count from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Since {
    /// 1970, UTC.
    Epoch,
    /// The departure of the trial.
    Departure,
}

/// The positions of a file, whose times ascend.
#[derive(Clone, Debug, PartialEq)]
pub struct LoggedPositions {
    /// What their times count from.
    pub since: Since,
    /// In the order of time, at least one.
    pub rows: Vec<LoggedPosition>,
    /// Inputs that were logged, by name: times, counted as those of positions, and values in the units of the vessel.
    pub inputs: BTreeMap<String, Vec<[f64; 2]>>,
    /// How many positions without a fix, or at 0 N 0 E, were left out.
    pub left_out: usize,
}

/// Appends a position to `rows`.
fn push(rows: &mut Vec<LoggedPosition>, next: LoggedPosition) -> Result<(), Invalid> {
    let line = format!("line {}", next.line);
    if rows.len() == MOST {
        let remedy = "thin them out: one a second is enough";
        return Err(Invalid::new(line, "one more position", format!("at most {MOST}"), remedy));
    }
    if let Some(last) = rows.last().filter(|last| next.at_s <= last.at_s) {
        let back_s = last.at_s - next.at_s;
        let time = match back_s {
            0.0 => format!("the time of line {}", last.line),
            _ => format!("a time {back_s:.3} s before that of line {}", last.line),
        };
        let remedy = "sort the positions, and keep one of each time";
        return Err(Invalid::new(format!("{line}, `time`"), time, "a later time", remedy));
    }
    rows.push(next);
    Ok(())
}

/// Positions without those at 0 N 0 E, of a log that ends at a time and has so many positions without a fix. Refuses one without
/// positions, and one that goes on without them; `expected` is what it should hold.
fn checked(
    since: Since,
    mut rows: Vec<LoggedPosition>,
    (ends_s, unfixed): (f64, usize),
    expected: &str,
) -> Result<LoggedPositions, LogError> {
    let (all, ends_s) = (rows.len(), rows.last().map_or(ends_s, |last| last.at_s.max(ends_s)));
    rows.retain(|row| [row.longitude_deg, row.latitude_deg] != [0.0; 2]);
    let Some(last) = rows.last() else {
        let remedy = "export the positions since the departure";
        let count = if all == 0 { "none" } else { "none but 0 N 0 E, which stands for no fix" };
        return Err(Invalid::new("positions", count, expected, remedy).into());
    };
    let stale_s = ends_s - last.at_s;
    if stale_s > STALE_S {
        let age = format!("the last fix, {stale_s:.0} s before the end of the log");
        let expected = format!("one in its last {STALE_S} s: she is elsewhere now");
        let remedy =
            "give a log that ends with a fix, or say where she is by --done STEPS --from LON,LAT,HEADING";
        return Err(Invalid::new(format!("line {}", last.line), age, expected, remedy).into());
    }
    let left_out = all - rows.len() + unfixed;
    Ok(LoggedPositions { since, rows, inputs: BTreeMap::new(), left_out })
}

/// Kinds of sentences with a position.
const PLACED: [&str; 4] = ["RMC", "GGA", "GNS", "GLL"];
/// A knot \[m/s\].
const KNOT_M_S: f64 = 1852.0 / 3600.0;
/// Positions of one receiver are no farther apart at the same time \[m\]; between rows so near she is on a straight line \[s\].
const APART_M: f64 = 8.0;
const NEIGHBOURS_S: f64 = 5.0;
/// A degree of latitude \[m\].
const DEGREE_M: f64 = 111_195.0;
/// Kinds with a true heading.
const HEADED: [&str; 2] = ["HDT", "THS"];

/// Reads positions from the first kind of sentence that has a fix once the date is known. Sentences without a right
/// checksum, without a fix or with the time of the one before are left out; other receivers are refused.
pub(crate) fn positions_in_sentences(bytes: impl BufRead) -> Result<LoggedPositions, LogError> {
    let (mut lines, mut reading) = (Lines::new(bytes)?, PositionReading::default());
    while let Some((number, line)) = lines.bytes()? {
        // Undecodable bytes fail their checksum.
        for raw in raw_sentences(&String::from_utf8_lossy(line)) {
            let (sentence, checksum) = raw.sentence();
            if checksum == Checksum::Right {
                reading.take(&sentence, number)?;
            }
        }
    }
    let expected = "sentences RMC, or GGA, GNS or GLL after a ZDA, with a fix and a right checksum";
    reading.check_alone()?;
    checked(Since::Epoch, reading.rows, (reading.ends_s, reading.unfixed), expected)
}

/// The state of reading.
#[derive(Default)]
struct PositionReading {
    /// The address of the sentences that positions are taken from.
    source: Option<String>,
    /// Midnight of the day, and the last time of that day, both in seconds.
    day: Option<[f64; 2]>,
    /// The last heading since the position before it \[deg\].
    heading_deg: Option<f64>,
    rows: Vec<LoggedPosition>,
    /// Positions of all other sentences, by address: line, time, longitude, latitude.
    others: BTreeMap<String, Vec<(usize, [f64; 3])>>,
    /// The time of the last sentence that could have had a position.
    ends_s: f64,
    /// Sentences of the source without a fix.
    unfixed: usize,
}

impl PositionReading {
    fn take(&mut self, sentence: &Sentence, line: usize) -> Result<(), Invalid> {
        if let Some(kind) = HEADED.iter().find(|kind| sentence.is_a(kind)) {
            self.heading_deg = value(sentence, kind, "heading", line)?.or(self.heading_deg);
            return Ok(());
        }
        let Some(at_s) = self.time(sentence, line)? else { return Ok(()) };
        let Some(kind) = PLACED.iter().find(|kind| sentence.is_a(kind)) else { return Ok(()) };
        self.ends_s = self.ends_s.max(at_s);
        let is_other = self.source.as_deref().is_some_and(|source| source != sentence.address);
        let field = |name: &str| value(sentence, kind, name, line);
        let (Some(longitude_deg), Some(latitude_deg)) = (field("longitude")?, field("latitude")?) else {
            self.unfixed += usize::from(!is_other);
            return Ok(());
        };
        if is_other || self.rows.last().is_some_and(|last| last.at_s == at_s) {
            let others = self.others.entry(sentence.address.to_owned()).or_default();
            if others.len() < self.rows.len() {
                others.push((line, [at_s, longitude_deg, latitude_deg]));
            }
            return Ok(());
        }
        let knots = if *kind == "RMC" { field("speed")? } else { None };
        let speed_m_s = knots.map(|knots| knots * KNOT_M_S);
        self.source.get_or_insert_with(|| sentence.address.to_owned());
        let heading_deg = self.heading_deg.take();
        push(
            &mut self.rows,
            LoggedPosition { line, at_s, longitude_deg, latitude_deg, heading_deg, speed_m_s },
        )
    }

    /// Refuses positions of another receiver: they differ at the same times.
    fn check_alone(&self) -> Result<(), Invalid> {
        for (address, others) in &self.others {
            let mut apart: Vec<(f64, usize)> =
                others.iter().filter_map(|(line, position)| Some((self.away_m(position)?, *line))).collect();
            apart.sort_by(|a, b| a.0.total_cmp(&b.0));
            if let Some((away_m, line)) =
                apart.get(apart.len() / 2).filter(|middle| middle.0 > APART_M && apart.len() > 2)
            {
                let source = self.source.as_deref().unwrap_or_default();
                let distance = format!(
                    "{} {away_m:.0} m away from {} at the same time",
                    foreign(address),
                    foreign(source)
                );
                let expected = format!("one receiver: positions within {APART_M} m");
                let remedy = match address == source {
                    true => "log one of the receivers alone".to_owned(),
                    false => {
                        format!("leave those of one out, such as by `grep -v {} FILE`", foreign(address))
                    }
                };
                return Err(Invalid::new(format!("line {line}"), distance, expected, remedy));
            }
        }
        Ok(())
    }

    /// The distance of a position (time, longitude, latitude) from the source's then \[m\].
    fn away_m(&self, [at_s, longitude, latitude]: &[f64; 3]) -> Option<f64> {
        let next = self.rows.partition_point(|row| row.at_s < *at_s).min(self.rows.len() - 1);
        let [a, b] = [next.saturating_sub(1), next].map(|k| &self.rows[k]);
        let part = if b.at_s > a.at_s { (at_s - a.at_s) / (b.at_s - a.at_s) } else { 0.0 };
        let is_between = (a.at_s..=b.at_s).contains(at_s) && b.at_s - a.at_s <= NEIGHBOURS_S;
        let [x, y] = [b.longitude_deg - a.longitude_deg, b.latitude_deg - a.latitude_deg];
        let [x, y] = [a.longitude_deg + part * x - longitude, a.latitude_deg + part * y - latitude];
        let east = x * libm::cos(latitude.to_radians());
        is_between.then(|| DEGREE_M * libm::hypot(east, y))
    }

    /// The time of a sentence since 1970 \[s\]; `None` where it has none, or the date is not known yet.
    fn time(&mut self, sentence: &Sentence, line: usize) -> Result<Option<f64>, Invalid> {
        let reported = reported_time(sentence).map_err(|(text, expected)| {
            let thing = format!("line {line}, {}", foreign(sentence.address));
            let quoted = format!("`{}`", foreign(text));
            Invalid::new(thing, quoted, expected, "correct or leave out the line")
        })?;
        let Some(reported) = reported else { return Ok(None) };
        if let Some(midnight) = reported.midnight.filter(|_| is_dated(sentence.address) && reported.is_fix) {
            self.day = Some([midnight, reported.of_day]);
        }
        let Some([midnight, last]) = self.day else { return Ok(None) };
        // Around midnight, sentences without a date are of the day that is nearest to the last time.
        let midnight = midnight + DAY * ((last - reported.of_day) / DAY).round();
        self.day = Some([midnight, reported.of_day]);
        Ok(Some(midnight + reported.of_day))
    }
}

/// A field of a sentence of `kind`; `None` where it is empty, or its quality does not count.
fn value(sentence: &Sentence, kind: &str, field: &str, line: usize) -> Result<Option<f64>, Invalid> {
    let Some(column) = FieldColumn::parse(&format!("{kind}.{field}")) else { return Ok(None) };
    Ok(match column.value(sentence, line, &Accepted::default())? {
        Value::Known(value) => Some(value),
        Value::Undeviated(_) | Value::Empty | Value::Left(_) => None,
    })
}
