//! A table in Markdown.

use study::documents::Quantiles;

use crate::number::{percent_within, three_within};

/// A table that is written column by column.
pub(super) struct Table<R> {
    heads: Vec<String>,
    rows: Vec<(R, Vec<String>)>,
}

impl<R> Table<R> {
    /// A row for each of `rows`.
    pub(super) fn of(rows: impl IntoIterator<Item = R>) -> Self {
        Self { heads: Vec::new(), rows: rows.into_iter().map(|row| (row, Vec::new())).collect() }
    }

    /// Adds a column with its head and its cells.
    pub(super) fn column(mut self, head: &str, cell: impl Fn(&R) -> String) -> Self {
        self.heads.push(head.to_owned());
        self.rows.iter_mut().for_each(|(row, cells)| cells.push(cell(row)));
        self
    }

    /// The whole table, or `None` without rows.
    pub(super) fn text(self) -> Option<String> {
        let line = |cells: &[String]| format!("| {} |\n", cells.join(" | "));
        let rows: String = self.rows.iter().map(|(_, cells)| line(cells)).collect();
        let head = format!("{}|{}\n", line(&self.heads), "---|".repeat(self.heads.len()));
        (!rows.is_empty()).then(|| head + &rows)
    }
}

/// A share and its interval; a dash if the document has none.
pub(super) fn share(value: f64, interval: Option<[f64; 2]>) -> String {
    percent_within(value, interval) + if interval.is_some() { "" } else { " (–)" }
}

/// A quantile and its interval; a dash if the document has none.
pub(super) fn quantile(value: Option<f64>, interval: Option<[Option<f64>; 2]>) -> String {
    three_within(value, interval) + if interval.is_some() { "" } else { " (–)" }
}

/// The median and its interval.
pub(super) fn median(errors: &Quantiles) -> String {
    quantile(errors.median, errors.median_interval)
}
