use super::number::{exact, percent};
use crate::figures::Histogram;

/// What the last bar holds and what no bar shows, per design: `optimized: 3 of 500 runs truncated, 0 without a value`.
pub(super) fn truncation(designs: &[(&str, &Histogram)], limit: f64) -> String {
    let parts = designs.iter().map(|(name, counted)| {
        let runs = counted.runs();
        let (beyond, missing) = (counted.beyond, counted.missing);
        format!("{name}: {beyond} of {runs} runs truncated, {missing} without a value")
    });
    let parts: Vec<String> = parts.collect();
    format!("Values at or above {} are truncated into the last bar ({}).", exact(limit), parts.join("; "))
}

/// `98.6 % below 5`.
pub(super) fn below(share: f64, bound: f64) -> String {
    format!("{} below {}", percent(share), exact(bound))
}
