//! Downloads of the page: its numbers as CSV and as JSON, in data links.

use std::fmt::Write;

use maud::{Markup, html};
use study::documents::{SweepAxis, SweepDocument, SweptLine};

use super::axes::written;

/// Links to the numbers.
pub(super) fn downloads(sweep: &SweepDocument) -> Markup {
    let json = serde_json::to_string_pretty(sweep).unwrap_or_default();
    html! {
        p {
            a download="sweep.csv" href=(link("text/csv", &csv(sweep))) { "sweep.csv" } " · "
            a download="sweep-data.json" href=(link("application/json", &json)) { "sweep-data.json" }
        }
        p.note { "All numbers of this page, within it: a row per cell and line; intervals are 95 % intervals." }
    }
}

const COLUMNS: [&str; 15] = [
    "design",
    "estimator",
    "runs",
    "parameter_error_share",
    "parameter_error_share_low",
    "parameter_error_share_high",
    "simulation_error_share",
    "simulation_error_share_low",
    "simulation_error_share_high",
    "parameter_error_median",
    "parameter_error_median_low",
    "parameter_error_median_high",
    "difference",
    "difference_low",
    "difference_high",
];

/// A row per cell and line; missing values are empty. Refused cells only have their refusal.
pub(super) fn csv(sweep: &SweepDocument) -> String {
    let keys = sweep.axes.iter().map(|axis| quoted(&axis.key));
    let head = std::iter::once("cell".to_owned()).chain(keys).chain(COLUMNS.map(str::to_owned));
    let mut text = head.chain(["paired", "refusal"].map(str::to_owned)).collect::<Vec<_>>().join(",") + "\n";
    for cell in &sweep.cells {
        for line in &cell.lines {
            text += &row(sweep, &cell.cell, &cell.at, numbers(line));
        }
    }
    for cell in &sweep.refused {
        let empty = std::iter::repeat_n(String::new(), COLUMNS.len() + 1);
        text += &row(sweep, &cell.cell, &cell.at, empty.chain([quoted(&cell.refusal)]));
    }
    text
}

fn row(sweep: &SweepDocument, cell: &str, at: &[usize], rest: impl IntoIterator<Item = String>) -> String {
    let value = |(axis, place): (&SweepAxis, &usize)| {
        axis.values.get(*place).map_or_else(String::new, |value| quoted(&written(value)))
    };
    let first = std::iter::once(cell.to_owned()).chain(sweep.axes.iter().zip(at).map(value));
    first.chain(rest).collect::<Vec<_>>().join(",") + "\n"
}

fn numbers(line: &SweptLine) -> Vec<String> {
    let number = |value: Option<f64>| value.map_or_else(String::new, |value| value.to_string());
    let ends = |ends: Option<[f64; 2]>| ends.map_or([None, None], |ends| ends.map(Some));
    let (parameter, simulation) = (line.parameter_error_share, line.simulation_error_share);
    let shares = [parameter, simulation].map(|share| {
        let [low, high] = ends(share.interval);
        [Some(share.share), low, high]
    });
    let [low, high] = line.parameter_error_median_interval;
    let [from, to] = ends(line.difference.map(|difference| difference.interval));
    let last = [line.parameter_error_median, low, high, line.difference.map(|d| d.share), from, to];
    let paired = line.difference.map_or_else(String::new, |d| d.paired.to_string());
    [line.design.clone(), line.estimator.to_string(), line.runs.to_string()]
        .into_iter()
        .chain(shares.into_iter().flatten().chain(last).map(number))
        .chain([paired, String::new()])
        .collect()
}

fn quoted(text: &str) -> String {
    if text.contains([',', '"', '\n']) {
        format!("\"{}\"", text.replace('"', "\"\""))
    } else {
        text.to_owned()
    }
}

/// A data URI with `text`.
fn link(kind: &str, text: &str) -> String {
    let mut address = format!("data:{kind};charset=utf-8,");
    for byte in text.bytes() {
        if byte.is_ascii_alphanumeric() || b"-_.~,:[]{}()".contains(&byte) {
            address.push(char::from(byte));
        } else {
            // Writing to a string does not fail.
            let _ = write!(address, "%{byte:02X}");
        }
    }
    address
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_address_holds_any_text() {
        assert_eq!(link("text/csv", "a,\"ü\"\n"), "data:text/csv;charset=utf-8,a,%22%C3%BC%22%0A");
        assert_eq!(quoted("a, \"b\""), "\"a, \"\"b\"\"\"");
    }
}
