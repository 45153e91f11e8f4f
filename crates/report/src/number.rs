//! Numbers as the page prints them.

use std::fmt::Display;

use study::documents::{DesignScores, Quantiles};

use crate::figures::text::{signed as minus, superscript};

const MISSING: &str = "–";

/// `value` with three significant digits: `−0.0600`, `125`, `1.40·10⁻⁵`; a dash if it is not finite.
pub(super) fn three(value: f64) -> String {
    if !value.is_finite() {
        return MISSING.to_owned();
    }
    if value == 0.0 {
        return "0".to_owned();
    }
    let (mantissa, exponent) = rounded(value);
    if (-3..5).contains(&exponent) { plain(value, exponent) } else { scientific(mantissa, exponent) }
}

/// As [`three`], with a dash for none.
pub(super) fn three_or_dash(value: Option<f64>) -> String {
    three(value.unwrap_or(f64::NAN))
}

/// The ends of an interval, or a dash for none.
pub(super) fn interval(ends: Option<[f64; 2]>) -> String {
    or_dash(ends.map(|[low, high]| format!("{} to {}", three(low), three(high))))
}

/// The value, or a dash.
pub(super) fn or_dash(value: Option<impl Display>) -> String {
    value.map_or(MISSING.to_owned(), |value| value.to_string())
}

/// A whole number or a short decimal as it was given: `125`, `0.15`.
pub(super) fn exact(value: f64) -> String {
    if value.is_finite() { minus(&format!("{value}")) } else { MISSING.to_owned() }
}

/// A share (0 to 1) in percent with one decimal.
pub(super) fn percent(share: f64) -> String {
    or_dash(share.is_finite().then(|| format!("{}\u{a0}%", minus(&format!("{:.1}", 100.0 * share)))))
}

/// What is simulated at once: `windows of 60 s`, or whole recordings.
pub(super) fn windows_of(window_s: Option<f64>) -> String {
    window_s.map_or("whole recordings".to_owned(), |s| format!("windows of {} s", exact(s)))
}

/// A probability: `0.043`, `< 0.001`.
pub(super) fn probability(p: f64) -> String {
    if p < 0.001 { "< 0.001".to_owned() } else { format!("{p:.3}") }
}

/// A fit: `79.2 %`, or a dash.
pub(super) fn fit(fit: Option<f64>) -> String {
    percent(fit.map_or(f64::NAN, |fit| fit / 100.0))
}

/// A share with its 95 % interval: `98.6 % (97.9 to 99.1 %)`; without it if there is none.
pub(super) fn percent_within(share: f64, interval: Option<[f64; 2]>) -> String {
    let Some([low, high]) = interval else { return percent(share) };
    let bare = |share: f64| percent(share).replace("\u{a0}%", "");
    format!("{} ({} to {})", percent(share), bare(low), percent(high))
}

/// A quantile with its 95 % interval: `1.43 (1.31 to 1.60)`; `∞` at an end that the values do not bound.
pub(super) fn three_within(value: Option<f64>, interval: Option<[Option<f64>; 2]>) -> String {
    let end = |end: Option<f64>| end.map_or("∞".to_owned(), three);
    match (value, interval) {
        (Some(value), Some([Some(low), high])) => {
            format!("{} ({} to {})", three(value), three(low), end(high))
        }
        (Some(value), Some([None, Some(high)])) => format!("{} (up to {})", three(value), three(high)),
        _ => three_or_dash(value),
    }
}

/// The median with its interval.
pub(super) fn median(errors: &Quantiles) -> String {
    three_within(errors.median, errors.median_interval)
}

/// The 90 % quantile with its interval.
pub(super) fn q90(errors: &Quantiles) -> String {
    three_within(errors.q90, errors.q90_interval)
}

/// The share of runs whose parameter error is below the bound.
pub(super) fn parameter_share(scores: &DesignScores) -> String {
    percent_within(scores.parameter_error_share, scores.parameter_error_share_interval)
}

/// The share of runs whose simulation error is below the bound.
pub(super) fn simulation_share(scores: &DesignScores) -> String {
    percent_within(scores.simulation_error_share, scores.simulation_error_share_interval)
}

/// A share in percent as published: no more decimals than it has.
pub(super) fn published(share: f64) -> String {
    let rounded = (share * 1e6).round() / 1e4;
    if rounded.is_finite() { format!("{rounded}\u{a0}%") } else { MISSING.to_owned() }
}

/// A unit in brackets; `[1]` for none.
pub(super) fn unit(unit: &str) -> String {
    format!("[{}]", if unit.is_empty() { "1" } else { unit })
}

/// The decimal exponent and mantissa after rounding to three digits.
fn rounded(value: f64) -> (f64, i32) {
    let text = format!("{value:.2e}");
    let (mantissa, exponent) = text.split_once('e').unwrap_or((&text, "0"));
    (mantissa.parse().unwrap_or(value), exponent.parse().unwrap_or(0))
}

fn plain(value: f64, exponent: i32) -> String {
    let decimals = usize::try_from(2 - exponent).unwrap_or(0);
    minus(&format!("{value:.decimals$}"))
}

fn scientific(mantissa: f64, exponent: i32) -> String {
    minus(&format!("{mantissa:.2}·10{}", superscript(exponent)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn three_significant_digits() {
        let printed = [-0.06, 125.0, 1.4e-5, 0.9996, 12_345.0, 1.234e7, 0.0, f64::NAN].map(three);
        assert_eq!(printed, ["−0.0600", "125", "1.40·10⁻⁵", "1.00", "12345", "1.23·10⁷", "0", "–"]);
    }

    #[test]
    fn intervals_stand_in_brackets() {
        assert_eq!(percent_within(0.5, Some([0.4, 0.6])), "50.0\u{a0}% (40.0 to 60.0\u{a0}%)");
        assert_eq!(percent_within(0.5, None), "50.0\u{a0}%");
        assert_eq!(three_within(Some(1.43), Some([Some(1.31), Some(1.6)])), "1.43 (1.31 to 1.60)");
        assert_eq!(three_within(Some(1.43), Some([Some(1.31), None])), "1.43 (1.31 to ∞)");
        assert_eq!(three_within(Some(1.43), Some([None, Some(2.0)])), "1.43 (up to 2.00)");
        assert_eq!(three_within(Some(1.43), Some([None; 2])), "1.43");
        assert_eq!(three_within(None, None), "–");
    }

    #[test]
    fn shares_in_percent() {
        assert_eq!(percent(0.9861), "98.6\u{a0}%");
        assert_eq!(published(0.49), "49\u{a0}%");
        assert_eq!(published(0.07), "7\u{a0}%");
        assert_eq!(percent(f64::INFINITY), "–");
    }
}
