use std::sync::Arc;

use refusal::{Invalid, nearest};

use crate::TimeUnit;

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
    Numbers(Vec<f64>),
    /// Empty where there is none. Rows that follow each other share a label.
    Labels(Vec<Arc<str>>),
}

impl Cells {
    /// No cells yet of a column that holds `content`.
    pub fn none(content: Content) -> Self {
        match content {
            Content::Labels => Self::Labels(Vec::new()),
            Content::Numbers | Content::Dates => Self::Numbers(Vec::new()),
        }
    }
}

/// Seconds since 1970 of a date and time; NaN where there is none, nothing where it is something else.
pub fn seconds_of(text: &str) -> Option<f64> {
    TimeUnit::of_text(text).or_else(|| text.is_empty().then_some(f64::NAN))
}

/// What is wrong with a cell that should hold a date.
pub fn no_date(line: usize, column: &str, text: &str, written_in: &str) -> Invalid {
    Invalid::new(
        cell_of(line, column),
        format!("`{text}`"),
        "a date and time such as 2020-07-31T13:04:24.5Z",
        format!("correct the cell, or the time's `unit` in {written_in}"),
    )
}

/// Appends a label to others.
pub fn push_label(labels: &mut Vec<Arc<str>>, label: &str) {
    match labels.last().filter(|last| ***last == *label).cloned() {
        Some(same) => labels.push(same),
        None => labels.push(Arc::from(label)),
    }
}

/// The columns of a file as asked for.
#[derive(Clone, Debug, PartialEq)]
pub struct Columns {
    /// In the order asked for.
    pub cells: Vec<Cells>,
    /// Line (CSV) or row (Parquet) of every row, from 1.
    pub lines: Vec<u32>,
    /// Rows without any value, left out.
    pub empty_rows: usize,
    /// Rows cut short at the end of the file, left out.
    pub cut_rows: usize,
}

impl Columns {
    /// Sets memory aside for `rows` rows in all.
    pub(crate) fn reserve(&mut self, rows: usize) {
        let more = rows.saturating_sub(self.lines.len());
        self.lines.reserve_exact(more);
        self.cells.iter_mut().for_each(|cells| match cells {
            Cells::Numbers(numbers) => numbers.reserve_exact(more),
            Cells::Labels(labels) => labels.reserve_exact(more),
        });
    }

    /// Gives back the memory that was set aside for more rows.
    pub(crate) fn shrink(&mut self) {
        self.lines.shrink_to_fit();
        self.cells.iter_mut().for_each(|cells| match cells {
            Cells::Numbers(numbers) => numbers.shrink_to_fit(),
            Cells::Labels(labels) => labels.shrink_to_fit(),
        });
    }
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
