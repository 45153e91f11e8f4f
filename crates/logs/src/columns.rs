use std::fmt::Display;
use std::sync::Arc;

use numerics::statistics::streamed_median;
use refusal::{Invalid, foreign, nearest, some_of};

use crate::samples::steps;
use crate::{Labels, Numbering, Omissions, Samples, Store, WarningSummary};

/// A requested column.
#[derive(Clone, Debug, PartialEq)]
pub struct WantedColumn {
    /// Its name.
    pub column: String,
    /// What it holds.
    pub content: Content,
}

/// What a column holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Content {
    /// Numbers.
    Numbers,
    /// Dates and times as text.
    Dates,
    /// Labels.
    Labels,
}

/// The values of a column.
#[derive(Clone, Debug, PartialEq)]
pub enum Cells {
    /// NaN where there is no value; for dates the seconds since 1970.
    Numbers(Samples),
    /// Empty where there is none.
    Labels(Labels),
}

impl Cells {
    /// An empty column for `content`; `store`, if any, takes blocks of numbers.
    pub fn none(content: Content, store: Option<&Arc<dyn Store>>) -> Self {
        match content {
            Content::Labels => Self::Labels(Labels::default()),
            Content::Numbers | Content::Dates => {
                Self::Numbers(store.map_or_else(Samples::default, Samples::new))
            }
        }
    }
}

/// The requested columns of a file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Columns {
    /// In the order requested.
    pub cells: Vec<Cells>,
    /// Line (CSV) or row (Parquet) of every row, from 1.
    pub lines: Numbering,
    /// Rows without any value, left out.
    pub empty_rows: usize,
    /// Rows cut short at the end of the file, left out.
    pub cut_rows: usize,
    /// Sentences with a wrong checksum, left out.
    pub wrong_checksums: usize,
    /// Values left out, by column and reason.
    pub omitted: Omissions,
    /// Sentences that came twice, left out.
    pub repeated: usize,
    /// Whether rows follow a stamp with their time.
    pub is_stamped: bool,
    /// Whether rows may be late, so that they have to be sorted by time.
    pub is_sorted: bool,
    /// Sentences of the clock that came late and set no time.
    pub late: usize,
    /// Sentences that neither a channel nor the clock takes, and lines without a sentence.
    pub unused: usize,
    /// Oddities of these columns.
    pub warnings: Vec<WarningSummary>,
    /// Columns with clocks of their own, which replace those above.
    pub apart: Vec<Apart>,
    /// Findings about the times.
    pub clock: ClockNotes,
}

impl Columns {
    /// The time of the first row that has one, and of the last.
    pub fn span(&self) -> Option<[f64; 2]> {
        if !self.apart.is_empty() {
            let spans = self.apart.iter().filter_map(|apart| apart.columns.span());
            return spans.reduce(|[a, b], [c, d]| [a.min(c), b.max(d)]);
        }
        let Some(Cells::Numbers(times)) = self.cells.first() else { return None };
        let known = times.iter().filter(|time| time.is_finite());
        known.fold(None, |span: Option<[f64; 2]>, time| {
            Some(span.map_or([time; 2], |[first, _]| [first, time]))
        })
    }

    /// Names the file that the rows are from; its rows come before those of others.
    #[must_use]
    pub fn of_part(mut self, name: &str) -> Self {
        self.lines = self.lines.of_part(name);
        for apart in &mut self.apart {
            apart.columns.lines = std::mem::take(&mut apart.columns.lines).of_part(name);
        }
        self
    }

    /// Appends the rows of `others`, the same columns of the file that follows.
    pub fn append(&mut self, mut others: Self) {
        self.append_apart(&mut others);
        let Self { cells, lines, empty_rows, cut_rows, wrong_checksums, omitted, clock, .. } = others;
        self.is_stamped |= others.is_stamped;
        self.is_sorted |= others.is_sorted;
        self.late += others.late;
        self.unused += others.unused;
        self.repeated += others.repeated;
        self.warnings.extend(others.warnings);
        // The clock continues into the next file, which knows of no leap second in an earlier one.
        let leap_s = self.clock.leap_s.filter(|_| clock.leap_s.is_none() && !self.clock.of_day);
        for (place, (column, other)) in self.cells.iter_mut().zip(cells).enumerate() {
            let late =
                |time: f64| if place == 0 && leap_s.is_some_and(|s| time >= s) { time + 1.0 } else { time };
            match (column, other) {
                (Cells::Numbers(column), Cells::Numbers(other)) => {
                    other.iter().for_each(|n| column.push(late(n)))
                }
                (Cells::Labels(column), Cells::Labels(other)) => {
                    (0..other.len()).for_each(|row| column.push(other.at(row)));
                }
                _ => {}
            }
        }
        self.lines.append(lines);
        self.empty_rows += empty_rows;
        self.cut_rows += cut_rows;
        self.wrong_checksums += wrong_checksums;
        self.omitted.append(&omitted, |column| column);
        self.clock.of_day |= clock.of_day;
        self.clock.leap_s = self.clock.leap_s.or(clock.leap_s);
        self.clock.fractions.append(clock.fractions);
    }

    /// Appends the columns of the sensors of `others`; dateless ones continue a day later where they begin anew.
    fn append_apart(&mut self, others: &mut Self) {
        let begins_anew = match (self.span(), others.span()) {
            (Some([_, last]), Some([first, _])) => others.clock.of_day && first < last - 0.5 * DAY,
            _ => false,
        };
        let last = self.span().map_or(0.0, |[_, last]| last);
        let days = |first: f64| DAY * ((last - 0.5 * DAY - first) / DAY).ceil();
        let moved = if begins_anew { others.span().map_or(0.0, |[first, _]| days(first)) } else { 0.0 };
        for mut other in std::mem::take(&mut others.apart) {
            if let (true, Some(Cells::Numbers(times))) = (moved > 0.0, other.columns.cells.first_mut()) {
                *times = times.made(times.iter().map(|time| time + moved));
            }
            let places = |apart: &Apart| apart.channels.iter().map(|(place, _)| *place).collect::<Vec<_>>();
            let same = |apart: &&mut Apart| apart.source == other.source && places(apart) == places(&other);
            match self.apart.iter_mut().find(same) {
                Some(apart) => apart.columns.append(other.columns),
                None => self.apart.push(other),
            }
        }
    }
}

/// Columns of one sensor, the first of them its clock.
#[derive(Clone, Debug, PartialEq)]
pub struct Apart {
    /// Its name in messages.
    pub source: String,
    /// Indices of the channels that the other columns hold, and the sensor's rank among the sources of each,
    /// from 0; `None` where there is only one source.
    pub channels: Vec<(usize, Option<usize>)>,
    /// The columns.
    pub columns: Columns,
}

/// A day \[s\].
const DAY: f64 = 86_400.0;

/// What is known about a file's times after reading.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ClockNotes {
    /// Whether they are times of day without a date.
    pub of_day: bool,
    /// The moment of a leap second, from which on they are a second later than the clock showed \[s\].
    pub leap_s: Option<f64>,
    /// Their numbers of decimals.
    pub fractions: Fractions,
}

/// Texts that stand for no value, in any case and with any sign and brackets.
const NOTHING: [&str; 29] = [
    "",
    "nan",
    "nan(ind)",
    "nan(snan)",
    "1.#qnan",
    "1.#snan",
    "1.#ind",
    "1.#inf",
    "inf",
    "infinity",
    "na",
    "n/a",
    "#n/a",
    "#na",
    "#n/a n/a",
    "<na>",
    "nat",
    "null",
    "(null)",
    "nil",
    "none",
    "-",
    "--",
    ".",
    "#value!",
    "#div/0!",
    "#num!",
    "#ref!",
    "missing",
];

/// Whether a cell holds no value.
pub(crate) fn is_nothing(cell: &str) -> bool {
    let cell = cell.trim();
    let is = |text: &str| NOTHING.iter().any(|nothing| nothing.eq_ignore_ascii_case(text));
    is(cell) || cell.strip_prefix(['-', '+']).is_some_and(is)
}

/// How messages name a cell.
pub(crate) fn cell_of(line: impl Display, column: &str) -> String {
    format!("line {line}, column `{column}`")
}

/// The index of each wanted column in `header`.
///
/// # Errors
/// Names all missing columns at once, or one that occurs several times.
pub fn places(header: &[String], wanted: &[WantedColumn]) -> Result<Vec<usize>, Invalid> {
    let place = |wanted: &WantedColumn| header.iter().position(|column| *column == wanted.column);
    let places: Vec<usize> = wanted.iter().filter_map(place).collect();
    let count = |wanted: &WantedColumn| header.iter().filter(|column| **column == wanted.column).count();
    if let Some(twice) = wanted.iter().find(|wanted| count(wanted) > 1) {
        let thing = format!("column `{}`", foreign(&twice.column));
        let counted = format!("{} of this name", count(twice));
        let remedy = "rename all but one, so that the column is unambiguous";
        return Err(Invalid::new(thing, counted, "one", remedy));
    }
    if places.len() == wanted.len() {
        return Ok(places);
    }
    let mut missing: Vec<&str> = Vec::new();
    for WantedColumn { column, .. } in wanted {
        if !header.contains(column) && !missing.contains(&column.as_str()) {
            missing.push(column);
        }
    }
    let remedy = |column: &&str| match nearest(column, header.iter().map(String::as_str)) {
        Some(near) => format!("did you mean `{near}` instead of `{column}`?"),
        None => format!("add `{column}`"),
    };
    Err(Invalid::new(
        if missing.len() == 1 { "column" } else { "columns" },
        format!("no `{}`", missing.join("`, `")),
        format!("columns among {}", some_of(header, missing.first().copied().unwrap_or_default())),
        missing.iter().map(remedy).collect::<Vec<_>>().join(" "),
    ))
}

// Times whose decimals are a whole number of nano- or microseconds, printed without leading zeros: `12.5` for 12 s and 5 µs.

/// How many decimals the times of a file have, as long as they may be such numbers.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Fractions {
    /// One per row.
    digits: Vec<u8>,
    /// A time was seen that cannot be such a number.
    is_plain: bool,
    /// Some end in zero, as numbers in shortest form do not.
    has_zeros: bool,
}

/// How much more even steps must become before times are read the other way.
const MORE_EVEN: f64 = 4.0;

impl Fractions {
    /// Takes the time of the next row, whose decimals follow `decimal`.
    pub fn see(&mut self, text: &str, decimal: char) {
        if self.is_plain {
            return;
        }
        match digits_of(text, decimal) {
            Some(digits) if digits.len() == 1 || !digits.starts_with('0') => {
                self.has_zeros |= digits.len() > 1 && digits.ends_with('0');
                self.digits.push(digits.len().min(9) as u8);
            }
            // A row without a time.
            None if !text.contains(|c: char| c.is_ascii_digit()) => self.digits.push(0),
            _ => (self.is_plain, self.digits) = (true, Vec::new()),
        }
    }

    /// Appends the decimals of the following rows.
    pub(crate) fn append(&mut self, others: Self) {
        self.is_plain |= others.is_plain;
        self.has_zeros |= others.has_zeros;
        self.digits.extend(others.digits);
        if self.is_plain {
            self.digits = Vec::new();
        }
    }

    /// `times` \[s\] as they are meant, and how many rows that changes.
    pub(crate) fn padded(&self, times: Samples) -> (Samples, usize) {
        let lengths = || self.digits.iter().copied().filter(|digits| *digits > 0);
        let (Some(least), Some(most)) = (lengths().min(), lengths().max()) else { return (times, 0) };
        if self.is_plain || self.digits.len() != times.len() {
            return (times, 0);
        }
        let unit = if most > 6 {
            9
        } else if most > 3 {
            6
        } else {
            3
        };
        let rows = times.iter().zip(&self.digits);
        let meant = times.made(rows.map(|(time, digits)| {
            let whole = time.floor();
            let number = ((time - whole) * 10_f64.powi(i32::from(*digits))).round();
            whole + number * 10_f64.powi(-unit)
        }));
        // If all rows have equally many digits, they were printed so, with zeros at the end.
        match least < most && self.has_zeros || is_more_even(&meant, &times) {
            true => (meant, lengths().filter(|digits| i32::from(*digits) < unit).count()),
            false => (times, 0),
        }
    }
}

/// Whether the steps of `times` go back less often than those of `others`, or are far more even.
fn is_more_even(times: &Samples, others: &Samples) -> bool {
    let [first, other] = [times, others].map(|times| {
        let steps = || steps(times.iter().filter(|time| time.is_finite()));
        let back = steps().filter(|step| *step < 0.0).count();
        let usual = streamed_median(steps).unwrap_or(0.0);
        (back, steps().map(|step| (step - usual).abs()).sum::<f64>())
    });
    other.0 > MORE_EVEN as usize * first.0 || other.0 == first.0 && other.1 > MORE_EVEN * first.1
}

/// The decimals at the end of a time, or before its zone.
fn digits_of(text: &str, decimal: char) -> Option<&str> {
    let (before, after) = text.trim().rsplit_once(decimal)?;
    let end = after.find(|c: char| !c.is_ascii_digit()).unwrap_or(after.len());
    let (digits, rest) = after.split_at(end);
    let is_zone = || rest.starts_with(['Z', 'z', '+', '-']);
    let is_apart =
        || rest.strip_prefix(' ').is_some_and(|rest| !rest.starts_with(|c: char| c.is_ascii_digit()));
    let ends = rest.is_empty() || is_zone() || is_apart();
    (!digits.is_empty() && before.ends_with(|c: char| c.is_ascii_digit()) && ends).then_some(digits)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn padded(texts: &[String]) -> (Vec<f64>, usize) {
        let mut fractions = Fractions::default();
        texts.iter().for_each(|text| fractions.see(text, '.'));
        let times: Vec<f64> = texts.iter().map(|text| text.parse().unwrap()).collect();
        let (times, moved) = fractions.padded(times.into());
        (times.to_vec(), moved)
    }

    #[test]
    fn law_numbers_without_leading_zeros_are_times_again() {
        for (unit, digits) in [(1_000_000_000_u64, 9), (1_000_000, 6), (1000, 3)] {
            for step_ms in [20, 100, 250, 1000] {
                let stamp =
                    |k: u64| (170_000_000 * unit) + k * step_ms * unit / 1000 + (7 * k * k) % 13 * unit / 500;
                let texts: Vec<String> =
                    (0..200).map(|k| format!("{}.{}", stamp(k) / unit, stamp(k) % unit)).collect();
                let (times, _) = padded(&texts);
                for (k, time) in times.iter().enumerate() {
                    let truth = (stamp(k as u64) as f64) / unit as f64;
                    assert!(
                        (time - truth).abs() < 1e-6,
                        "{digits} digits, {step_ms} ms: {time}, not {truth}"
                    );
                }
            }
        }
    }

    /// Four digits in every row: 2.0 to 8.6 ms after each second.
    #[test]
    fn numbers_of_as_many_digits_are_recognized_by_how_even_their_steps_are() {
        let micros = |k: usize| 2000 + (k * 7 % 13) * 550;
        let texts: Vec<String> = (0..61).map(|k| format!("{}.{}", 50_000 + k, micros(k))).collect();
        let (times, moved) = padded(&texts);
        assert_eq!(moved, 61);
        for (k, time) in times.iter().enumerate() {
            assert!((time - (50_000 + k) as f64 - micros(k) as f64 * 1e-6).abs() < 1e-9, "{time}");
        }
    }

    #[test]
    fn decimals_that_are_written_short_or_with_all_digits_stay() {
        for step in [0.01, 0.05, 0.1, 0.25, 0.5, 1.0] {
            let short: Vec<String> = (0..200).map(|k| format!("{}", 10.0 + step * f64::from(k))).collect();
            let one: Vec<String> = (0..200).map(|k| format!("{:?}", 10.0 + step * f64::from(k))).collect();
            let long: Vec<String> = (0..200).map(|k| format!("{:.3}", 10.0 + step * f64::from(k))).collect();
            for texts in [short, one, long] {
                assert_eq!(padded(&texts).1, 0, "{step}: {:?}", &texts[..9]);
            }
        }
        assert_eq!(digits_of("2020-07-31T13:04:24.25+09:00", '.'), Some("25"));
        assert_eq!(digits_of("11.04.2025 12:08:20", '.'), None);
        assert_eq!(digits_of("12:08:20.5", '.'), Some("5"));
    }
}
