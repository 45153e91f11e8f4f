//! Positions of a ship in sentences.

use std::io::BufRead;

use refusal::{Invalid, foreign};

use super::clock::{DAY, is_dated, reported_time};
use super::fields::{Column, Value};
use super::quality::Accepted;
use super::sentence::{Checksum, Sentence, raw_sentences};
use crate::LogError;
use crate::lines::Lines;
use crate::position::{LoggedPosition, LoggedPositions, Since, checked, push};

/// Kinds of sentences with a position.
const PLACED: [&str; 4] = ["RMC", "GGA", "GNS", "GLL"];
/// A knot \[m/s\].
const KNOT_M_S: f64 = 1852.0 / 3600.0;
/// Kinds with a true heading.
const HEADED: [&str; 2] = ["HDT", "THS"];

/// Reads positions from the first kind of sentence that has a fix once the date is known. Sentences without a right
/// checksum, without a fix or with the time of the one before are left out.
pub(crate) fn positions_in_sentences(bytes: impl BufRead) -> Result<LoggedPositions, LogError> {
    let (mut lines, mut reading) = (Lines::new(bytes)?, Reading::default());
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
    checked(Since::Epoch, reading.rows, expected)
}

/// The state of reading.
#[derive(Default)]
struct Reading {
    /// The address of the sentences that positions are taken from.
    source: Option<String>,
    /// Midnight of the day, and the last time of that day, both in seconds.
    day: Option<[f64; 2]>,
    /// The last heading since the position before it \[deg\].
    heading_deg: Option<f64>,
    rows: Vec<LoggedPosition>,
}

impl Reading {
    fn take(&mut self, sentence: &Sentence, line: usize) -> Result<(), Invalid> {
        if let Some(kind) = HEADED.iter().find(|kind| sentence.is_a(kind)) {
            self.heading_deg = value(sentence, kind, "heading", line)?.or(self.heading_deg);
            return Ok(());
        }
        let Some(at_s) = self.time(sentence, line)? else { return Ok(()) };
        let Some(kind) = PLACED.iter().find(|kind| sentence.is_a(kind)) else { return Ok(()) };
        if self.source.as_deref().is_some_and(|source| source != sentence.address) {
            return Ok(());
        }
        let field = |name: &str| value(sentence, kind, name, line);
        let (Some(longitude_deg), Some(latitude_deg)) = (field("longitude")?, field("latitude")?) else {
            return Ok(());
        };
        if self.rows.last().is_some_and(|last| last.at_s == at_s) {
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

    /// The time of a sentence since 1970 \[s\]; `None` where it has none, or the date is not known yet.
    fn time(&mut self, sentence: &Sentence, line: usize) -> Result<Option<f64>, Invalid> {
        let reported = reported_time(sentence).map_err(|(text, expected)| {
            let thing = format!("line {line}, {}", foreign(sentence.address));
            let found = format!("`{}`", foreign(text));
            Invalid::new(thing, found, expected, "correct or leave out the line")
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
    let Some(column) = Column::parse(&format!("{kind}.{field}")) else { return Ok(None) };
    Ok(match column.value(sentence, line, &Accepted::default())? {
        Value::Known(value) => Some(value),
        Value::Undeviated(_) | Value::Empty | Value::Left(_) => None,
    })
}
