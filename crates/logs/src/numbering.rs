//! Names of rows: their labels, and the lines that they stand on.

use std::sync::Arc;

use refusal::foreign;

/// Labels of rows. Consecutive rows share one.
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
    /// The first rows of the source files, and their names, where there are several.
    parts: Vec<(usize, String)>,
    rows: usize,
    /// Rows that do not stand on the line after that of the previous row, and their lines.
    breaks: Vec<(usize, usize)>,
}

impl Numbering {
    /// Rows that stand on the lines from 1 on.
    pub fn of_rows(rows: usize) -> Self {
        Self { rows, breaks: vec![(0, 1)], ..Self::default() }
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

    /// Names the file that the rows are from; its rows come before those of others.
    #[must_use]
    pub fn of_part(mut self, name: &str) -> Self {
        self.parts = vec![(0, name.to_owned())];
        self
    }

    /// The first rows of all files but the first.
    pub(crate) fn seams(&self) -> impl Iterator<Item = (usize, &str)> {
        self.parts.iter().skip(1).map(|(row, name)| (*row, name.as_str()))
    }

    pub(crate) fn append(&mut self, others: Self) {
        let before = self.rows;
        self.parts.extend(others.parts.into_iter().map(|(row, name)| (row + before, name)));
        self.breaks.extend(others.breaks.into_iter().map(|(row, line)| (row + before, line)));
        self.rows += others.rows;
    }

    /// The line of `row` in words, with its file where there are several.
    pub(crate) fn place(&self, row: usize) -> String {
        let line = self.line(row);
        match self.parts.iter().rfind(|(first, _)| *first <= row).filter(|_| self.parts.len() > 1) {
            Some((_, name)) => format!("{line} of `{}`", foreign(name)),
            None => line.to_string(),
        }
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
