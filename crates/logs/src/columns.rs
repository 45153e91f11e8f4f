use std::fmt::Display;
use std::sync::Arc;

use refusal::{Invalid, foreign, nearest, some_of};

use crate::{Fractions, Labels, Numbering, Omissions, Samples, Store, WarningSummary};

/// A requested column.
#[derive(Clone, Debug, PartialEq)]
pub struct Wanted {
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
            let spans = self.apart.iter().filter_map(|own| own.columns.span());
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
        for (place, (own, other)) in self.cells.iter_mut().zip(cells).enumerate() {
            let late =
                |time: f64| if place == 0 && leap_s.is_some_and(|s| time >= s) { time + 1.0 } else { time };
            match (own, other) {
                (Cells::Numbers(own), Cells::Numbers(other)) => other.iter().for_each(|n| own.push(late(n))),
                (Cells::Labels(own), Cells::Labels(other)) => {
                    (0..other.len()).for_each(|row| own.push(other.at(row)));
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

    /// Appends the columns of the sensors of `others`; dateless ones continue a day later where they begin
    /// anew.
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
            let same = |own: &&mut Apart| own.source == other.source && own.has_channels_of(&other);
            match self.apart.iter_mut().find(same) {
                Some(own) => own.columns.append(other.columns),
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

impl Apart {
    fn has_channels_of(&self, other: &Self) -> bool {
        self.channels.iter().map(|(channel, _)| channel).eq(other.channels.iter().map(|(channel, _)| channel))
    }
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
pub fn places(header: &[String], wanted: &[Wanted]) -> Result<Vec<usize>, Invalid> {
    let place = |wanted: &Wanted| header.iter().position(|column| *column == wanted.column);
    let places: Vec<usize> = wanted.iter().filter_map(place).collect();
    let count = |wanted: &Wanted| header.iter().filter(|column| **column == wanted.column).count();
    if let Some(twice) = wanted.iter().find(|wanted| count(wanted) > 1) {
        let thing = format!("column `{}`", foreign(&twice.column));
        let found = format!("{} of this name", count(twice));
        let remedy = "rename all but one, so that the column is unambiguous";
        return Err(Invalid::new(thing, found, "one", remedy));
    }
    if places.len() == wanted.len() {
        return Ok(places);
    }
    let mut missing: Vec<&str> = Vec::new();
    for Wanted { column, .. } in wanted {
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
