//! Logs of NMEA 0183: sentences such as `$GPRMC,…*5A`, a line each.
//!
//! Sentences have no time of their own: they have that of the last sentence of a stated kind, or of a stamp before them. What
//! arrives between two stamps are rows of one time; where a kind of sentence comes several times, its rows are shared out
//! evenly, so that `repeated = "spread"` gives each its time.
//!
//! Libraries for this standard read what tells a position and leave out rudders, rates of turn and propellers, which a model
//! needs. What there is to a sentence is a checksum and commas. Hence no library.

mod clock;
mod fields;
mod sentence;

use std::collections::BTreeMap;
use std::io::BufRead;
use std::sync::Arc;

use refusal::{Invalid, nearest};

use crate::lines::Lines;
use crate::{Cells, Columns, Content, LogError, Plan, Store, factor};
use clock::Clock;
use fields::{Column, columns};
use sentence::sentence;

/// Reads the fields of sentences that `plan` wants of files of group `group` (`HDT.heading`); numbers are put aside in `store`.
///
/// # Errors
/// Bytes that cannot be read, fields that there are not, in another unit or never in the file, more wrong checksums than may be.
pub fn read_nmea(
    bytes: impl BufRead,
    plan: &Plan,
    group: usize,
    store: Option<&Arc<dyn Store>>,
) -> Result<Columns, LogError> {
    let spec = &plan.setup.files[group];
    let wanted: Vec<Column> = spec
        .plain()
        .iter()
        .map(|channel| column(&channel.column, &channel.unit))
        .collect::<Result<_, _>>()?;
    let clock = Clock::new(&spec.time.column, plan.stamps(group), spec.time.is_text())?;
    let mut reading = Reading { wanted, clock, made: made(plan, group, store), ..Reading::new(plan) };
    let mut lines = Lines::new(bytes)?;
    while let Some((number, line)) = lines.bytes()? {
        // What is no text fails its checksum.
        reading.line(&String::from_utf8_lossy(line), number)?;
    }
    reading.finish(spec.max_wrong_checksums)
}

fn made(plan: &Plan, group: usize, store: Option<&Arc<dyn Store>>) -> Columns {
    let numbers = plan.wanted(group).len();
    let cells = (0..numbers).map(|_| Cells::none(Content::Numbers, store)).collect();
    Columns { cells, ..Columns::default() }
}

/// The column that is called `name`; refuses another unit than the sentence has.
fn column(name: &str, unit: &str) -> Result<Column, Invalid> {
    let Some(column) = Column::parse(name) else {
        let known: Vec<String> = columns().collect();
        let near = nearest(name, known.iter().map(String::as_str));
        let remedy = near.map_or("correct it".to_owned(), |near| format!("did you mean `{near}`?"));
        let expected = format!("a field of a sentence: {}", known.join(", "));
        return Err(Invalid::new("column", format!("`{name}`"), expected, remedy));
    };
    let own = column.field.unit;
    if factor(unit, own) != Some(1.0) {
        let expected = format!("`{own}`, as the sentence has it");
        return Err(Invalid::new(
            format!("unit of column `{name}`"),
            format!("`{unit}`"),
            expected,
            "correct it",
        ));
    }
    Ok(column)
}

/// A sentence that has something that is wanted.
struct Heard {
    line: usize,
    /// Its address and qualifier: which sentences are of one kind.
    kind: String,
    /// Places among the wanted columns, and the values there.
    values: Vec<(usize, f64)>,
}

/// What is read so far.
struct Reading<'a> {
    plan: &'a Plan,
    wanted: Vec<Column>,
    clock: Clock<'a>,
    made: Columns,
    /// Sentences since the last stamp.
    heard: Vec<Heard>,
    /// The time of these \[s\].
    time: f64,
    /// How often each kind of sentence came.
    kinds: BTreeMap<String, usize>,
    sentences: usize,
    first_wrong: Option<usize>,
    /// Whether the last sentence has no checksum at all: it may have been cut short.
    last_is_cut: bool,
}

impl<'a> Reading<'a> {
    fn new(plan: &'a Plan) -> Self {
        Self {
            plan,
            wanted: Vec::new(),
            clock: Clock::none(),
            made: Columns::default(),
            heard: Vec::new(),
            time: f64::NAN,
            kinds: BTreeMap::new(),
            sentences: 0,
            first_wrong: None,
            last_is_cut: false,
        }
    }

    /// Takes a line; one without a sentence is passed over.
    fn line(&mut self, line: &str, number: usize) -> Result<(), LogError> {
        let Some(start) = line.find('$') else { return Ok(()) };
        self.sentences += 1;
        self.last_is_cut = !line[start..].contains('*');
        let Some(sentence) = sentence(&line[start..]) else {
            self.made.wrong_checksums += 1;
            self.first_wrong.get_or_insert(number);
            return Ok(());
        };
        *self.kinds.entry(sentence.address.to_owned()).or_default() += 1;
        if let Some(time) = self.clock.time(&line[..start], &sentence, number, self.plan.setup.written_in)? {
            // Stamps before each sentence may be the same.
            if time != self.time {
                self.put()?;
            }
            self.time = time;
        }
        let own = self.wanted.iter().enumerate().filter(|(_, column)| column.is_of(&sentence));
        let values = own.map(|(place, column)| Ok((place, column.field.value(&sentence, number)?)));
        let values = values.collect::<Result<Vec<_>, Invalid>>()?;
        if !values.is_empty() {
            let kind = format!(
                "{}{:?}",
                sentence.address,
                values.iter().map(|(place, _)| place).collect::<Vec<_>>()
            );
            self.heard.push(Heard { line: number, kind, values });
        }
        Ok(())
    }

    /// Rows of what was heard since the last stamp: as many as sentences of the kind that came most often.
    fn put(&mut self) -> Result<(), LogError> {
        let heard = std::mem::take(&mut self.heard);
        let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
        heard.iter().for_each(|one| *counts.entry(&one.kind).or_default() += 1);
        let rows = counts.values().copied().max().unwrap_or(0);
        let mut table = vec![vec![f64::NAN; self.wanted.len()]; rows];
        let mut first_lines = vec![None; rows];
        let mut seen: BTreeMap<&str, usize> = BTreeMap::new();
        for one in &heard {
            let nth = seen.entry(&one.kind).or_default();
            let row = *nth * rows / counts[one.kind.as_str()];
            *nth += 1;
            first_lines[row].get_or_insert(one.line);
            one.values.iter().for_each(|(place, value)| table[row][*place] = *value);
        }
        let mut line = heard.first().map_or(0, |one| one.line);
        for (values, first) in table.into_iter().zip(first_lines) {
            line = line.max(first.unwrap_or(line));
            self.row(&values, line)?;
        }
        Ok(())
    }

    fn row(&mut self, values: &[f64], line: usize) -> Result<(), LogError> {
        if self.made.lines.rows() >= self.plan.most_rows {
            return Err(LogError::Invalid(self.plan.too_many_rows(line)));
        }
        self.made.lines.push(line);
        for (cells, value) in self.made.cells.iter_mut().zip([self.time].iter().chain(values)) {
            if let Cells::Numbers(numbers) = cells {
                numbers.push(*value);
            }
        }
        Ok(())
    }

    fn finish(mut self, share: f64) -> Result<Columns, LogError> {
        self.put()?;
        if self.last_is_cut && self.made.wrong_checksums > 0 {
            self.made.wrong_checksums -= 1;
            self.made.cut_rows = 1;
        }
        let wrong = self.made.wrong_checksums;
        if wrong as f64 > share * self.sentences as f64 {
            let first = self.first_wrong.unwrap_or(0);
            return Err(LogError::Invalid(Invalid::new(
                "checksums",
                format!("{wrong} wrong ones of {} sentences, the first in line {first}", self.sentences),
                format!("a share of at most {share}"),
                "log again over a better line, or raise `max_wrong_checksums`",
            )));
        }
        self.missing().map_or(Ok(self.made), |missing| Err(LogError::Invalid(missing)))
    }

    /// What is said where a wanted sentence, or the one with the time, never came.
    fn missing(&self) -> Option<Invalid> {
        let came = |column: &&Column| self.kinds.keys().any(|address| column.fits(address));
        let lacking = self.wanted.iter().find(|column| !came(column)).map(|column| column.name.as_str());
        let lacking = lacking.or_else(|| self.clock.lacks(self.kinds.keys()))?;
        let known: Vec<&str> = self.kinds.keys().map(String::as_str).collect();
        Some(Invalid::new(
            format!("column `{lacking}`"),
            "no such sentence in the file",
            format!(
                "sentences among {}",
                if known.is_empty() { "none".to_owned() } else { known.join(", ") }
            ),
            "name a field of one of these, or another file",
        ))
    }
}
