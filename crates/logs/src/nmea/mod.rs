//! Logs of NMEA 0183: sentences such as `$GPRMC,…*5A`.
//!
//! Sentences with a time have that one; all others have the time of the last sentence of a declared kind, or of a stamp
//! before them. Each address is a sensor with rows of its own; `repeated = "spread"` spaces rows of one time evenly.
//!
//! Libraries for this standard read positions and leave out rudders, rates of turn and propellers, which a
//! model needs. A sentence is a checksum and commas. Hence no library.

mod census;
mod clockwork;
pub(crate) mod fields;
pub(crate) mod sentence;
mod table;
pub(crate) mod timeline;

use std::io::BufRead;
use std::sync::Arc;

use refusal::{Invalid, foreign, nearest};

use crate::encoding::Lines;
use crate::{
    Apart, ChannelSpec, Columns, FileSpec, LogError, Plan, Store, WarningKind, WarningSummary, factor,
};
use census::Census;
use clockwork::SentenceClock;
use fields::{FieldColumn, columns_like};
use sentence::raw_sentences;
use table::{Heard, SensorTable};
use timeline::has_time;

pub use census::{Spoken, SpokenField, has_sentences, sentence_census};
pub use sentence::Accepted;

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
    let wanted: Vec<FieldColumn> = spec.plain().iter().map(column).collect::<Result<_, _>>()?;
    let clock = SentenceClock::new(spec, plan.setup.max_gap_s, plan.stamps(group))?;
    let census = Census::new(spec, &wanted);
    let (tables, heard) = (Vec::new(), Heard::default());
    let mut reading = SentenceReading { plan, spec, wanted, store, clock, census, tables, heard, unused: 0 };
    let mut lines = Lines::new(bytes)?;
    while let Some((number, line)) = lines.bytes()? {
        // Undecodable bytes fail their checksum.
        reading.line(&String::from_utf8_lossy(line), number)?;
    }
    Ok(reading.finish()?)
}

/// The column of a channel; refuses another unit than the sentence's, and a magnetic heading in place of a true one.
fn column(spec: &ChannelSpec) -> Result<FieldColumn, Invalid> {
    let name = &spec.column;
    let Some(column) = FieldColumn::parse(name) else {
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
    if column.field.name == "magnetic" && spec.channel == "psi" && spec.offset == 0.0 {
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
struct SentenceReading<'a> {
    plan: &'a Plan,
    spec: &'a FileSpec,
    wanted: Vec<FieldColumn>,
    store: Option<&'a Arc<dyn Store>>,
    clock: SentenceClock<'a>,
    census: Census,
    tables: Vec<SensorTable>,
    heard: Heard,
    unused: usize,
}

impl SentenceReading<'_> {
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
            let table = known.or_else(|| {
                self.tables.push(SensorTable::of(&sentence, &self.wanted, self.store)?);
                Some(self.tables.len() - 1)
            });
            let Some(table) = table else { continue };
            if self.tables[table].rows() + self.heard.len() >= self.plan.most_rows {
                return Err(LogError::Invalid(self.plan.too_many_rows(number)));
            }
            let how = (self.wanted.as_slice(), &self.spec.quality);
            let to = (table, &mut self.tables[table]);
            self.heard.hear(to, &sentence, (number, timing.reported()), how)?;
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
            if column.field.name == "course" && self.spec.plain()[place].channel == "psi" {
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
        let came = |column: &&FieldColumn| self.census.addresses().any(|address| column.fits(address));
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

/// The tables that the channels are taken from.
struct Sources<'a> {
    wanted: &'a [FieldColumn],
    specs: &'a [ChannelSpec],
    /// Talkers, best first.
    prefer: &'a [String],
    /// The clock's name in messages.
    clock: &'a str,
}

/// Share of a table's sentences whose time may be far from the clock's.
const FEW: f64 = 0.1;

impl Sources<'_> {
    /// The tables as files of their own, with their channels; warnings are appended to `warnings`.
    fn apart(
        &self,
        tables: Vec<SensorTable>,
        clock: &SentenceClock,
        warnings: &mut Vec<WarningSummary>,
    ) -> Result<Vec<Apart>, Invalid> {
        let mut ranks: Vec<Vec<(usize, usize)>> = tables.iter().map(|_| Vec::new()).collect();
        for place in 0..self.wanted.len() {
            for (rank, table) in self.of_channel(place, &tables, warnings)?.into_iter().enumerate() {
                ranks[table].push((place, rank));
            }
        }
        let used = || tables.iter().zip(&ranks).filter(|(_, ranks)| !ranks.is_empty());
        used().try_for_each(|(table, _)| check_times(table, self.clock))?;
        used().for_each(|(table, ranks)| self.warn(table, ranks, warnings));
        let all = tables.into_iter().zip(ranks).map(|(table, ranks)| {
            let rank =
                |place: &usize| ranks.iter().find(|(ranked, _)| ranked == place).map(|(_, rank)| *rank);
            let channels = table.places.iter().map(|place| (*place, rank(place))).collect();
            let is_sorted = clock.is_in_order() && has_time(&table.address);
            let source = table.address.clone();
            Apart { source, channels, columns: table.into_columns(clock.is_stamping(), is_sorted) }
        });
        Ok(all.collect())
    }

    /// The tables that provide channel `place`, best first.
    fn of_channel(
        &self,
        place: usize,
        tables: &[SensorTable],
        warnings: &mut Vec<WarningSummary>,
    ) -> Result<Vec<usize>, Invalid> {
        let values = |table: &SensorTable| {
            let column = table.places.iter().position(|candidate| *candidate == place);
            column.map(|column| table.seen[column].values)
        };
        let candidates: Vec<(usize, usize)> =
            (0..tables.len()).filter_map(|i| Some((i, values(&tables[i])?))).collect();
        let known: Vec<usize> =
            candidates.iter().filter(|(_, values)| *values > 0).map(|(i, _)| *i).collect();
        let address = |i: &usize| tables[*i].address.as_str();
        let rank = |i: &usize| self.prefer.iter().position(|talker| address(i).starts_with(talker.as_str()));
        let mut named: Vec<usize> = known.iter().copied().filter(|i| rank(i).is_some()).collect();
        named.sort_by_key(rank);
        match (known.as_slice(), named.as_slice()) {
            ([], _) if candidates.iter().any(|(i, _)| tables[*i].is_incomplete(&self.wanted[place].name)) => {
                let addresses: Vec<&str> = candidates.iter().map(|(i, _)| address(i)).collect();
                Err(Invalid::new(
                    format!("column `{}`", self.wanted[place].name),
                    format!("no variation with its E or W in any sentence {}", addresses.join(", ")),
                    "deviation and variation, each with its direction, which make a magnetic heading a true one",
                    "name `HDG.magnetic` and set its `offset` to deviation and variation in rad, east above 0, or name HDT or THS",
                ))
            }
            ([], _) => Ok(candidates.first().map(|(i, _)| *i).into_iter().collect()),
            ([only], _) => {
                let empty: Vec<&str> =
                    candidates.iter().filter(|(i, _)| i != only).map(|(i, _)| address(i)).collect();
                if !empty.is_empty() {
                    let text =
                        format!("is from {} alone: {} never has a value", address(only), empty.join(", "));
                    warnings.push(self.warning(place, empty.len(), &text));
                }
                Ok(vec![*only])
            }
            (_, []) => Err(self.several(place, &known.iter().map(address).collect::<Vec<_>>())),
            _ => Ok(named),
        }
    }

    fn several(&self, place: usize, addresses: &[&str]) -> Invalid {
        let column = &self.wanted[place].name;
        let (of, field) = column.split_once('.').unwrap_or((column, ""));
        let qualifier = of.find('-').map_or("", |dash| &of[dash..]);
        let talkers: Vec<String> = addresses.iter().map(|address| format!("\"{}\"", &address[..2])).collect();
        Invalid::new(
            format!("column `{column}`"),
            format!("values of it from {}", addresses.join(" and ")),
            "one sensor for a channel",
            format!(
                "name it, such as `{}{qualifier}.{field}`, or set `prefer = [{}]` in [[file]]: the first counts, the others fill \
                 its gaps",
                addresses[0],
                talkers.join(", ")
            ),
        )
    }

    fn warn(&self, table: &SensorTable, ranks: &[(usize, usize)], warnings: &mut Vec<WarningSummary>) {
        for (place, seen) in table.places.iter().zip(&table.seen) {
            if !ranks.iter().any(|(ranked, _)| ranked == place) {
                continue;
            }
            if let Some((count, away)) = seen.alternation.two_sensors() {
                let text = format!(
                    "alternates by {away:.4} deg {count} times: two sensors may send {} under one name",
                    table.address
                );
                warnings.push(self.warning(*place, count, &text));
            }
            if seen.undeviated > 0 {
                let count = seen.undeviated;
                let text =
                    format!("is without deviation in {count} sentences of {}: 0 is assumed", table.address);
                warnings.push(self.warning(*place, count, &text));
            }
        }
    }

    /// A warning about channel `place` that occurred `count` times.
    fn warning(&self, place: usize, count: usize, text: &str) -> WarningSummary {
        let channel = self.specs[place].channel.clone();
        let text = format!("`{channel}` {text}");
        WarningSummary { kind: WarningKind::Source, channel, count: count as u64, text }
    }
}

/// Refuses a table whose times often differ from the clock's.
fn check_times(table: &SensorTable, clock: &str) -> Result<(), Invalid> {
    let all = table.far + table.rows();
    match table.first_far.filter(|_| table.far as f64 > FEW * all as f64) {
        Some((line, away)) => Err(Invalid::new(
            format!("times of {}", table.address),
            format!(
                "{} of {all} that differ from those of {clock}, the first in line {line}, {away:.0} s away",
                table.far
            ),
            "both on one clock",
            format!("name {} as the time's `column`, or another sentence for its channels", &table.address),
        )),
        None => Ok(()),
    }
}
