//! Logs of NMEA 0183: sentences such as `$GPRMC,…*5A`.
//!
//! Sentences with a time have that one; all others have the time of the last sentence of a declared kind, or
//! of a stamp before them. Each address is a sensor with rows of its own; `repeated = "spread"` spaces rows
//! of one time evenly.
//!
//! Libraries for this standard read positions and leave out rudders, rates of turn and propellers, which a
//! model needs. A sentence is a checksum and commas. Hence no library.

mod alternation;
mod census;
mod clock;
mod clockwork;
mod fields;
mod heard;
mod positions;
mod quality;
mod sentence;
mod sources;
mod spoken;
mod table;
mod timeline;
mod trust;

use std::io::BufRead;
use std::sync::Arc;

use refusal::{Invalid, foreign, nearest};

use crate::lines::Lines;
use crate::{ChannelSpec, Columns, FileSpec, LogError, Plan, Store, WarningSummary, factor};
use census::Census;
use clockwork::Clock;
use fields::{Column, columns_like};
use heard::Heard;
pub(crate) use positions::positions_in_sentences;
pub use quality::Accepted;
use sentence::raw_sentences;
use sources::Sources;
pub use spoken::{Spoken, SpokenField, has_sentences, sentence_census};
use table::Table;

/// Reads the fields of sentences that `plan` wants of files of group `group` (`HDT.heading`); `store` takes
/// blocks of numbers.
/// # Errors
/// Bytes that cannot be read, fields that are unknown, in another unit or never in the file, several sensors
/// for a channel, an unknown clock, more wrong checksums than allowed.
pub fn read_nmea(
    bytes: impl BufRead,
    plan: &Plan,
    group: usize,
    store: Option<&Arc<dyn Store>>,
) -> Result<Columns, LogError> {
    let spec = &plan.setup.files[group];
    let wanted: Vec<Column> = spec.plain().iter().map(column).collect::<Result<_, _>>()?;
    let clock = Clock::new(spec, plan.setup.max_gap_s, plan.stamps(group))?;
    let census = Census::new(spec, &wanted);
    let (tables, heard) = (Vec::new(), Heard::default());
    let mut reading = Reading { plan, spec, wanted, store, clock, census, tables, heard, unused: 0 };
    let mut lines = Lines::new(bytes)?;
    while let Some((number, line)) = lines.bytes()? {
        // Undecodable bytes fail their checksum.
        reading.line(&String::from_utf8_lossy(line), number)?;
    }
    Ok(reading.finish()?)
}

/// The column of a channel; refuses another unit than the sentence's, and a magnetic heading in place of a
/// true one.
fn column(spec: &ChannelSpec) -> Result<Column, Invalid> {
    let name = &spec.column;
    let Some(column) = Column::parse(name) else {
        let known = columns_like(name);
        let near = nearest(name, known.iter().map(String::as_str));
        let remedy = near.map_or("correct it".to_owned(), |near| format!("did you mean `{near}`?"));
        let expected = format!("a field of a sentence: {}", known.join(", "));
        return Err(Invalid::new("column", format!("`{name}`"), expected, remedy));
    };
    let unit = column.field.unit;
    if factor(&spec.unit, unit) != Some(1.0) {
        return Err(Invalid::new(
            format!("unit of column `{name}`"),
            format!("`{}`", spec.unit),
            format!("`{unit}`, as the sentence has it"),
            "correct it",
        ));
    }
    if column.is_magnetic() && spec.channel == "psi" && spec.offset == 0.0 {
        return Err(Invalid::new(
            "channel `psi`",
            format!("the magnetic heading `{name}`"),
            "a heading from true north",
            "name `HDG.heading`, which adds deviation and variation, or HDT or THS; or set `offset` to the variation in rad, east \
             above 0",
        ));
    }
    Ok(column)
}

/// The state of reading.
struct Reading<'a> {
    plan: &'a Plan,
    spec: &'a FileSpec,
    wanted: Vec<Column>,
    store: Option<&'a Arc<dyn Store>>,
    clock: Clock<'a>,
    census: Census,
    tables: Vec<Table>,
    heard: Heard,
    unused: usize,
}

impl Reading<'_> {
    /// Reads a line; one without a sentence is skipped.
    fn line(&mut self, line: &str, number: usize) -> Result<(), LogError> {
        let mut prefix = "";
        self.unused += usize::from(!line.trim().is_empty() && raw_sentences(line).next().is_none());
        for raw in raw_sentences(line) {
            // Sentences on one line share its stamp.
            prefix = if raw.prefix.trim().is_empty() { prefix } else { raw.prefix };
            let (sentence, checksum) = raw.sentence();
            if !self.census.take(&sentence, checksum, raw.is_followed, number) {
                continue;
            }
            let is_wanted = self.wanted.iter().any(|column| column.is_of(&sentence));
            let said = (is_wanted, self.plan.setup.written_in);
            let timing = self.clock.timing(prefix, &sentence, number, said)?;
            self.clock.step(timing, &sentence, (&mut self.heard, &mut self.tables, &self.wanted));
            if !is_wanted {
                self.unused += usize::from(!self.census.is_wanted(sentence.address));
                continue;
            }
            let known = self.tables.iter().position(|table| table.is_of(&sentence, &self.wanted));
            let table = match known {
                Some(table) => table,
                None => match Table::of(&sentence, &self.wanted, self.store) {
                    Some(table) => {
                        self.tables.push(table);
                        self.tables.len() - 1
                    }
                    None => continue,
                },
            };
            if self.tables[table].rows() + self.heard.len() >= self.plan.most_rows {
                return Err(LogError::Invalid(self.plan.too_many_rows(number)));
            }
            let how = (self.wanted.as_slice(), &self.spec.quality);
            let to = (table, &mut self.tables[table]);
            self.heard.hear(to, &sentence, (number, timing.own()), how)?;
        }
        Ok(())
    }

    fn finish(mut self) -> Result<Columns, Invalid> {
        self.clock.finish((&mut self.heard, &mut self.tables, &self.wanted));
        let mut columns = Columns { unused: self.unused, ..Columns::default() };
        (columns.wrong_checksums, columns.cut_rows) = self.census.finish(self.spec)?;
        if let Some(missing) = self.missing() {
            return Err(missing);
        }
        let mut warnings: Vec<WarningSummary> = Vec::new();
        columns.late = self.clock.check(&mut self.tables, &self.wanted, &mut warnings)?;
        let sources = Sources {
            wanted: &self.wanted,
            specs: self.spec.plain(),
            prefer: &self.spec.prefer,
            clock: &self.spec.time.column,
        };
        for (place, column) in self.wanted.iter().enumerate() {
            if column.is_course() && self.spec.plain()[place].channel == "psi" {
                let text = format!(
                    "is the course over ground of {}, not a heading: the drift angle is lost",
                    column.name
                );
                warnings.push(sources.warning(place, 1, &text));
            }
        }
        columns.apart = sources.apart(self.tables, &self.clock, &mut warnings)?;
        columns.warnings = warnings;
        columns.clock = self.clock.notes();
        columns.apart.iter_mut().for_each(|apart| apart.columns.clock = columns.clock.clone());
        Ok(columns)
    }

    /// The refusal where a wanted sentence, or the one with the time, never came.
    fn missing(&self) -> Option<Invalid> {
        let came = |column: &&Column| self.census.addresses().any(|address| column.fits(address));
        let lacking = self.wanted.iter().find(|column| !came(column)).map(|column| column.name.as_str());
        let lacking = lacking.or_else(|| self.clock.lacks(self.census.addresses()))?;
        let known: Vec<String> = self.census.addresses().map(foreign).collect();
        if known.is_empty() {
            return Some(Invalid::new(
                "file",
                "no sentence of NMEA 0183",
                "lines with sentences such as `$HEHDT,68.7,T*2A`",
                "name another file, or its `format`",
            ));
        }
        Some(Invalid::new(
            format!("column `{lacking}`"),
            "no such sentence in the file",
            format!("sentences among {}", known.join(", ")),
            "name a field of one of these, or another file",
        ))
    }
}
