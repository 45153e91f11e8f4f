//! A table in Markdown.

use crate::number::{percent, three, three_or_dash};

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

/// A share and its interval.
pub(super) fn share(value: f64, interval: Option<[f64; 2]>) -> String {
    let within = interval.map(|[low, high]| [percent(low), percent(high)]);
    with_interval(&percent(value), within)
}

/// A quantile and its interval; an end that is infinite has no number.
pub(super) fn quantile(value: Option<f64>, interval: Option<[Option<f64>; 2]>) -> String {
    let end = |end: Option<f64>| end.map_or("∞".to_owned(), three);
    with_interval(&three_or_dash(value), interval.map(|ends| ends.map(end)))
}

/// A value and its interval, or a dash for none.
fn with_interval(value: &str, interval: Option<[String; 2]>) -> String {
    match interval {
        Some([low, high]) => format!("{value} ({low} to {high})"),
        None => format!("{value} (–)"),
    }
}

/// A number, or a dash for none.
pub(super) fn whole(value: Option<u64>) -> String {
    value.map_or("–".to_owned(), |value| value.to_string())
}
