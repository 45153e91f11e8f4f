//! The rows of one sensor: the sentences of one address with wanted fields.

use std::sync::Arc;

use refusal::Invalid;

use super::fields::{FieldColumn, Value};
use super::sentence::{Accepted, Sentence};
use super::timeline::{Reported, Stamp, own_time};
use crate::{Cells, Columns, Numbering, Omissions, Reason, Samples, Store};

/// The rows of one address.
pub(super) struct SensorTable {
    /// Talker and kind.
    pub(super) address: String,
    /// Indices of its columns among the wanted ones.
    pub(super) places: Vec<usize>,
    times: Samples,
    lines: Numbering,
    cells: Vec<Samples>,
    pub(super) seen: Vec<ColumnState>,
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
pub(super) struct ColumnState {
    /// The number of values, and how many of them are headings without a deviation.
    pub(super) values: usize,
    pub(super) undeviated: usize,
    /// Whether any value had a deviation.
    is_deviated: bool,
    pub(super) alternation: Alternation,
}

impl SensorTable {
    /// An empty table for the columns of `wanted` that occur in `sentence`; `None` where none do.
    pub(super) fn of(
        sentence: &Sentence,
        wanted: &[FieldColumn],
        store: Option<&Arc<dyn Store>>,
    ) -> Option<Self> {
        let places: Vec<usize> = (0..wanted.len()).filter(|i| wanted[*i].is_of(sentence)).collect();
        let none = || store.map_or_else(Samples::default, Samples::new);
        (!places.is_empty()).then(|| Self {
            address: sentence.address.to_owned(),
            times: none(),
            lines: Numbering::default(),
            cells: places.iter().map(|_| none()).collect(),
            seen: places.iter().map(|_| ColumnState::default()).collect(),
            places,
            omitted: Omissions::default(),
            last: (f64::NAN, Vec::new()),
            repeated: 0,
            far: 0,
            first_far: None,
        })
    }

    /// Whether `sentence` is one of its rows.
    pub(super) fn is_of(&self, sentence: &Sentence, wanted: &[FieldColumn]) -> bool {
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
        (wanted, accepted): (&[FieldColumn], &Accepted),
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

    /// Appends a row with a time of its own; an exact repetition, as on a line that sends it twice, is left out.
    fn push_timed(&mut self, time: f64, line: usize, values: &[f64]) {
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
    fn leave(&mut self, away: f64, line: usize, values: &[f64], wanted: &[FieldColumn]) {
        self.far += 1;
        self.first_far.get_or_insert((line, away));
        for (place, _) in self.places.iter().zip(values).filter(|(_, value)| value.is_finite()) {
            self.omitted.add(&wanted[*place].name, Reason::Time, 1);
        }
    }

    /// Removes the times of the rows in `ranges`, and moves all others by `weeks_s`.
    pub(super) fn correct(&mut self, ranges: &[[usize; 2]], weeks_s: f64, wanted: &[FieldColumn]) {
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

    /// As the columns of a file; the flags say whether they follow stamps, and whether they must be sorted by time.
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

/// Detects values that jump and return.
#[derive(Default)]
pub(super) struct Alternation {
    /// The last two values, the latest first, and the number of values.
    last: [f64; 2],
    count: usize,
    /// Distance of the previous value from the mean of its neighbours.
    before: f64,
    /// How often values jumped and returned, and the mean size of these jumps.
    returns: usize,
    away: f64,
}

/// Least distance of two sensors, by field \[deg\]: two antennas are a metre apart.
const APART: [(&str, f64); 6] = [
    ("heading", 1.5),
    ("magnetic", 1.5),
    ("starboard", 1.5),
    ("port", 1.5),
    ("latitude", 1e-5),
    ("longitude", 1e-5),
];

/// The value before a jump deviates from the mean of its neighbours too, the other way, by at least this fraction.
const RETURN: f64 = 0.25;

/// Share of values that return if there are two sensors.
const SHARE: f64 = 0.15;

/// Least number of returns.
const SOME: usize = 6;

impl Alternation {
    /// Takes the next value of a field called `name`.
    fn see(&mut self, value: f64, name: &str) {
        let Some((_, apart)) = APART.into_iter().find(|(field, _)| *field == name) else { return };
        let [previous, first] = self.last;
        let turned = |difference: f64| difference - 360.0 * (difference / 360.0).round();
        // A steady turn keeps every value at the mean of its neighbours.
        let away = 0.5 * (turned(previous - first) - turned(value - previous));
        if self.count >= 2 {
            if away.abs() > apart && away * self.before < -RETURN * away * away {
                self.returns += 1;
                self.away += (away.abs() - self.away) / self.returns as f64;
            }
            self.before = away;
        }
        self.last = [value, previous];
        self.count += 1;
    }

    /// The number of returns and the mean jump, if there seem to be two sensors.
    pub(super) fn two_sensors(&self) -> Option<(usize, f64)> {
        let often = self.returns >= SOME && self.returns as f64 > SHARE * self.count as f64;
        often.then_some((self.returns, self.away))
    }
}

/// Sentences since the clock's last one.
#[derive(Default)]
pub(super) struct Heard {
    sentences: Vec<One>,
    /// Their values, concatenated.
    values: Vec<f64>,
}

struct One {
    table: usize,
    line: usize,
    /// The sentence's own time.
    reported: Option<Reported>,
    /// The index of its first value.
    from: usize,
}

/// The clock's times before and after sentences.
pub(super) struct Between {
    /// The time of sentences without one of their own \[s\]; NaN where it is unknown.
    pub(super) time: f64,
    pub(super) before: Option<Stamp>,
    pub(super) after: Option<Stamp>,
}

/// How far a sentence's own time may differ from the clock's \[s\].
const FAR: f64 = 3.0;

impl Heard {
    /// How many sentences there are.
    pub(super) fn len(&self) -> usize {
        self.sentences.len()
    }

    /// Reads a sentence of `table`, which stands on `line` and has the time `reported`.
    pub(super) fn hear(
        &mut self,
        (place, table): (usize, &mut SensorTable),
        sentence: &Sentence,
        (line, reported): (usize, Option<Reported>),
        how: (&[FieldColumn], &Accepted),
    ) -> Result<(), Invalid> {
        let from = self.values.len();
        table.read(sentence, line, how, &mut self.values)?;
        self.sentences.push(One { table: place, line, reported, from });
        Ok(())
    }

    /// Puts the first `count` sentences into their tables.
    pub(super) fn put(
        &mut self,
        count: usize,
        between: &Between,
        tables: &mut [SensorTable],
        wanted: &[FieldColumn],
    ) {
        for one in &self.sentences[..count] {
            let table = &mut tables[one.table];
            let values = &self.values[one.from..one.from + table.places.len()];
            let time = one.reported.map(|reported| own_time(&reported, between.before, between.after));
            match time {
                None => table.push(between.time, one.line, values),
                Some(None) => table.push(f64::NAN, one.line, values),
                Some(Some((_, away))) if away > FAR && values.iter().any(|value| value.is_finite()) => {
                    table.leave(away, one.line, values, wanted);
                }
                Some(Some((time, _))) => table.push_timed(time, one.line, values),
            }
        }
        let values = self.sentences.get(count).map_or(self.values.len(), |one| one.from);
        self.values.drain(..values);
        self.sentences.drain(..count);
        self.sentences.iter_mut().for_each(|one| one.from -= values);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn distance(values: impl Iterator<Item = f64>) -> Option<f64> {
        let mut alternation = Alternation::default();
        values.for_each(|value| alternation.see(value, "heading"));
        alternation.two_sensors().map(|(_, away)| away)
    }

    fn turning(k: usize) -> f64 {
        let t = 0.2 * k as f64;
        (350.0 + 35.0 * (0.13 * t).sin()).rem_euclid(360.0)
    }

    #[test]
    fn two_gyros_that_take_turns_are_found_and_a_turning_ship_is_not() {
        let mixed = |every: usize| (0..300).map(move |k| turning(k) + if k % every == 0 { 3.0 } else { 0.0 });
        assert!(
            [2, 3, 5]
                .into_iter()
                .all(|every| distance(mixed(every)).is_some_and(|away| (away - 3.0).abs() < 0.5))
        );
        assert!(distance((0..300).map(turning)).is_none());
        // White noise of a degree, and occasional spikes.
        let mut seed = 1_u64;
        let mut noise = move || {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            (seed >> 40) as f64 / (1_u64 << 23) as f64 - 1.0
        };
        assert!(distance((0..300).map(|k| turning(k) + noise())).is_none());
        assert!(distance((0..300).map(|k| turning(k) + if k % 40 == 0 { 20.0 } else { 0.0 })).is_none());
    }
}
