//! Positions of a ship in sentences.

use std::collections::BTreeMap;
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
    reading.check_alone()?;
    checked(Since::Epoch, reading.rows, (reading.ends_s, reading.unfixed), expected)
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
    /// Positions of all other sentences, by address: line, time, longitude, latitude.
    others: BTreeMap<String, Vec<(usize, [f64; 3])>>,
    /// The time of the last sentence that could have had a position.
    ends_s: f64,
    /// Sentences of the source without a fix.
    unfixed: usize,
}

impl Reading {
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
                others.iter().filter_map(|(line, own)| Some((self.away_m(own)?, *line))).collect();
            apart.sort_by(|a, b| a.0.total_cmp(&b.0));
            if let Some((away_m, line)) =
                apart.get(apart.len() / 2).filter(|own| own.0 > APART_M && apart.len() > 2)
            {
                let source = self.source.as_deref().unwrap_or_default();
                let found = format!(
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
                return Err(Invalid::new(format!("line {line}"), found, expected, remedy));
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
