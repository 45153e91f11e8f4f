use std::sync::Arc;

use refusal::{Invalid, nearest};

use crate::{Omissions, Samples, Store, WarningSummary};

/// A column that is asked for.
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
    /// NaN where there is no value; of dates the seconds since 1970.
    Numbers(Samples),
    /// Empty where there is none.
    Labels(Labels),
}

impl Cells {
    /// No cells yet of a column that holds `content`; numbers are put aside in `store` where there is one.
    pub fn none(content: Content, store: Option<&Arc<dyn Store>>) -> Self {
        match content {
            Content::Labels => Self::Labels(Labels::default()),
            Content::Numbers | Content::Dates => {
                Self::Numbers(store.map_or_else(Samples::default, Samples::new))
            }
        }
    }
}

/// Labels of rows. Rows that follow each other share one.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Labels {
    /// Each label with the row after the last that has it.
    runs: Vec<(Arc<str>, usize)>,
}

impl Labels {
    /// Number of rows.
    pub fn len(&self) -> usize {
        self.runs.last().map_or(0, |(_, end)| *end)
    }

    /// Whether there are no rows.
    pub fn is_empty(&self) -> bool {
        self.runs.is_empty()
    }

    /// Appends a row.
    pub fn push(&mut self, label: &str) {
        let end = self.len() + 1;
        match self.runs.last_mut().filter(|(last, _)| **last == *label) {
            Some((_, last)) => *last = end,
            None => self.runs.push((Arc::from(label), end)),
        }
    }

    /// The label of a row; empty where there is no such row.
    pub fn at(&self, row: usize) -> &str {
        let place = self.runs.partition_point(|(_, end)| *end <= row);
        self.runs.get(place).map_or("", |(label, _)| label)
    }
}

/// Lines of a file that rows stand on, from 1.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Numbering {
    rows: usize,
    /// Rows that do not stand on the line after that of the row before them, and their lines.
    breaks: Vec<(usize, usize)>,
}

impl Numbering {
    /// Rows that stand on the lines from 1 on.
    pub fn of_rows(rows: usize) -> Self {
        Self { rows, breaks: vec![(0, 1)] }
    }

    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// Appends a row that stands on `line`.
    pub fn push(&mut self, line: usize) {
        if self.rows == 0 || self.line(self.rows) != line {
            self.breaks.push((self.rows, line));
        }
        self.rows += 1;
    }

    /// The line that `row` stands on.
    pub fn line(&self, row: usize) -> usize {
        let last = self.breaks.last().filter(|(first, _)| *first <= row);
        let found = last.or_else(|| {
            self.breaks.get(self.breaks.partition_point(|(first, _)| *first <= row).checked_sub(1)?)
        });
        found.map_or(0, |(first, line)| line + row - first)
    }
}

/// The columns of a file as asked for.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Columns {
    /// In the order asked for.
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
    /// Whether rows follow a stamp with their time.
    pub is_stamped: bool,
    /// Whether rows may come late: they are put in the order of time.
    pub is_sorted: bool,
    /// Sentences of the clock that came late and told no time.
    pub late: usize,
    /// What is odd about them.
    pub warnings: Vec<WarningSummary>,
    /// Columns with clocks of their own, in place of those above.
    pub apart: Vec<Apart>,
}

/// Columns of one sensor, the first of them its clock.
#[derive(Clone, Debug, PartialEq)]
pub struct Apart {
    /// What messages call it.
    pub source: String,
    /// Places of the channels that the others are, and which choice the sensor is for each, from 0; none where it is none.
    pub channels: Vec<(usize, Option<usize>)>,
    /// The columns.
    pub columns: Columns,
}

/// What messages call a cell.
pub(crate) fn cell_of(line: usize, column: &str) -> String {
    format!("line {line}, column `{column}`")
}

/// The place of each wanted column in `header`.
///
/// # Errors
/// Names all columns that are missing at once.
pub fn places(header: &[String], wanted: &[Wanted]) -> Result<Vec<usize>, Invalid> {
    let place = |wanted: &Wanted| header.iter().position(|column| *column == wanted.column);
    let places: Vec<usize> = wanted.iter().filter_map(place).collect();
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
        format!("columns among `{}`", header.join("`, `")),
        missing.iter().map(remedy).collect::<Vec<_>>().join(" "),
    ))
}
