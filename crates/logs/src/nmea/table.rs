//! The rows of one sensor: the sentences of one address with wanted fields.

use std::sync::Arc;

use refusal::Invalid;

use super::alternation::Alternation;
use super::fields::{Column, Value};
use super::quality::Accepted;
use super::sentence::Sentence;
use crate::{Cells, Columns, Numbering, Omissions, Reason, Samples, Store};

/// The rows of one address.
pub(super) struct Table {
    /// Talker and kind.
    pub(super) address: String,
    /// Indices of its columns among the wanted ones.
    pub(super) places: Vec<usize>,
    times: Samples,
    lines: Numbering,
    cells: Vec<Samples>,
    pub(super) seen: Vec<Seen>,
    omitted: Omissions,
    /// The last row, and how many exact repetitions came.
    last: (f64, Vec<f64>),
    repeated: usize,
    /// Rows whose own time is far from the clock's, and the first of them: its line and the distance \[s\].
    pub(super) far: usize,
    pub(super) first_far: Option<(usize, f64)>,
}

/// How a column of a table looks.
#[derive(Default)]
pub(super) struct Seen {
    /// The number of values, and how many of them are headings without a deviation.
    pub(super) values: usize,
    pub(super) undeviated: usize,
    /// Whether any value had a deviation.
    is_deviated: bool,
    pub(super) alternation: Alternation,
}

impl Table {
    /// An empty table for the columns of `wanted` that occur in `sentence`; `None` where none do.
    pub(super) fn of(sentence: &Sentence, wanted: &[Column], store: Option<&Arc<dyn Store>>) -> Option<Self> {
        let places: Vec<usize> = (0..wanted.len()).filter(|i| wanted[*i].is_of(sentence)).collect();
        let none = || store.map_or_else(Samples::default, Samples::new);
        (!places.is_empty()).then(|| Self {
            address: sentence.address.to_owned(),
            times: none(),
            lines: Numbering::default(),
            cells: places.iter().map(|_| none()).collect(),
            seen: places.iter().map(|_| Seen::default()).collect(),
            places,
            omitted: Omissions::default(),
            last: (f64::NAN, Vec::new()),
            repeated: 0,
            far: 0,
            first_far: None,
        })
    }

    /// Whether `sentence` is one of its rows.
    pub(super) fn is_of(&self, sentence: &Sentence, wanted: &[Column]) -> bool {
        self.address == sentence.address && self.places.iter().all(|place| wanted[*place].is_of(sentence))
    }

    /// Number of rows.
    pub(super) fn rows(&self) -> usize {
        self.lines.rows()
    }

    /// Appends its values in `sentence` to `values`, NaN where one is missing.
    pub(super) fn read(
        &mut self,
        sentence: &Sentence,
        line: usize,
        (wanted, accepted): (&[Column], &Accepted),
        values: &mut Vec<f64>,
    ) -> Result<(), Invalid> {
        for (place, seen) in self.places.iter().zip(&mut self.seen) {
            let column = &wanted[*place];
            let value = match column.value(sentence, line, accepted)? {
                // Earlier headings were corrected for deviation, this one is not.
                Value::Undeviated(_) if seen.is_deviated => Value::Left(Reason::Incomplete),
                value => value,
            };
            seen.undeviated += usize::from(matches!(value, Value::Undeviated(_)));
            seen.is_deviated |= matches!(value, Value::Known(_));
            values.push(match value {
                Value::Known(value) | Value::Undeviated(value) => {
                    seen.values += 1;
                    seen.alternation.see(value, column.field.name);
                    value
                }
                Value::Empty => f64::NAN,
                Value::Left(reason) => {
                    self.omitted.add(&column.name, reason, 1);
                    f64::NAN
                }
            });
        }
        Ok(())
    }

    /// Whether values of the column `name` lack what they are made of.
    pub(super) fn is_incomplete(&self, name: &str) -> bool {
        self.omitted.as_slice().iter().any(|one| one.channel == name && one.reason == Reason::Incomplete)
    }

    /// Appends a row.
    pub(super) fn push(&mut self, time: f64, line: usize, values: &[f64]) {
        self.times.push(time);
        self.lines.push(line);
        self.cells.iter_mut().zip(values).for_each(|(cells, value)| cells.push(*value));
    }

    /// Appends a row with a time of its own; an exact repetition, as on a line that sends it twice, is left
    /// out.
    pub(super) fn push_timed(&mut self, time: f64, line: usize, values: &[f64]) {
        let same = |(a, b): (&f64, &f64)| a.to_bits() == b.to_bits();
        if time == self.last.0 && values.iter().zip(&self.last.1).all(same) {
            self.repeated += 1;
            return;
        }
        self.last.0 = time;
        self.last.1.clear();
        self.last.1.extend_from_slice(values);
        self.push(time, line, values);
    }

    /// Leaves out a row whose own time is `away` from the clock's \[s\].
    pub(super) fn leave(&mut self, away: f64, line: usize, values: &[f64], wanted: &[Column]) {
        self.far += 1;
        self.first_far.get_or_insert((line, away));
        for (place, _) in self.places.iter().zip(values).filter(|(_, value)| value.is_finite()) {
            self.omitted.add(&wanted[*place].name, Reason::Time, 1);
        }
    }

    /// Removes the times of the rows in `ranges`, and moves all others by `weeks_s`.
    pub(super) fn correct(&mut self, ranges: &[[usize; 2]], weeks_s: f64, wanted: &[Column]) {
        if weeks_s != 0.0 {
            self.times = self.times.made(self.times.iter().map(|time| time + weeks_s));
        }
        for [from, to] in ranges.iter().filter(|[from, to]| from < to) {
            for (place, cells) in self.places.iter().zip(&self.cells) {
                let lost = cells.range(*from..*to).filter(|value| value.is_finite()).count();
                self.omitted.add(&wanted[*place].name, Reason::Time, lost as u64);
            }
            let time = |(row, time)| if (*from..*to).contains(&row) { f64::NAN } else { time };
            self.times = self.times.made(self.times.iter().enumerate().map(time));
        }
    }

    /// As the columns of a file; the flags say whether they follow stamps, and whether they must be sorted by
    /// time.
    pub(super) fn into_columns(self, is_stamped: bool, is_sorted: bool) -> Columns {
        let cells = [self.times].into_iter().chain(self.cells).map(Cells::Numbers).collect();
        Columns {
            cells,
            lines: self.lines,
            omitted: self.omitted,
            repeated: self.repeated,
            is_stamped,
            is_sorted,
            ..Columns::default()
        }
    }
}
