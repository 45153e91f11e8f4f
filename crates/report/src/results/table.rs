//! A table in Markdown.

use crate::number::{percent_within, three_within};

/// Heads and rows of one table.
pub(super) struct Table {
    columns: usize,
    text: String,
}

impl Table {
    /// A table with these heads.
    pub(super) fn new(heads: &[&str]) -> Self {
        let line = "---|".repeat(heads.len());
        Self { columns: heads.len(), text: format!("| {} |\n|{line}\n", heads.join(" | ")) }
    }

    /// Adds a row with as many cells as there are heads.
    pub(super) fn row(&mut self, cells: &[String]) {
        debug_assert_eq!(cells.len(), self.columns);
        self.text.push_str(&format!("| {} |\n", cells.join(" | ")));
    }

    /// The whole table, or nothing where it has no row.
    pub(super) fn text(self) -> Option<String> {
        (self.text.lines().count() > 2).then_some(self.text)
    }
}

/// A share and its interval; a dash where the document has none.
pub(super) fn share(value: f64, interval: Option<[f64; 2]>) -> String {
    percent_within(value, interval) + if interval.is_some() { "" } else { " (–)" }
}

/// A quantile and its interval; a dash where the document has none.
pub(super) fn quantile(value: Option<f64>, interval: Option<[Option<f64>; 2]>) -> String {
    three_within(value, interval) + if interval.is_some() { "" } else { " (–)" }
}

/// A number, or a dash for none.
pub(super) fn whole(value: Option<u64>) -> String {
    value.map_or("–".to_owned(), |value| value.to_string())
}
