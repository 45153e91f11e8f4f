use numerics::statistics::median_interval_in_words;
use refusal::listed;
use regression::pooled::{COLLINEAR, Whiteness};

use super::DegreeTrust;

/// Instruments are weak if they explain less than this share of a regressor.
const WEAK: f64 = 0.1;
/// A test fails below this probability.
const UNLIKELY: f64 = 0.01;

/// Increments of noise correlate by −0.5, which weights that fall with the lag do not compensate: standard errors are
/// too large.
const ALTERNATING: f64 = -0.3;

/// Warnings about an estimate, in words.
pub fn statements(degrees: &[DegreeTrust]) -> Vec<String> {
    degrees.iter().flat_map(of_degree).collect()
}

fn of_degree(degree: &DegreeTrust) -> Vec<String> {
    if let Some(reason) = &degree.reason {
        return vec![format!("not identifiable: {reason}")];
    }
    let collinear = (degree.condition_index.is_none_or(|index| index > COLLINEAR))
        .then(|| format!("collinear, use for similar motion only: {}", degree.weakest));
    let whiteness = degree.whiteness.as_ref().filter(|w| w.p_value < UNLIKELY);
    let statements = [at_bounds(degree), collinear, weak(degree), whiteness.map(|w| not_white(degree, w))];
    statements.into_iter().flatten().collect()
}

fn at_bounds(degree: &DegreeTrust) -> Option<String> {
    let ended = degree.parameters.iter().filter(|p| p.at_bound);
    let ended: Vec<String> = ended.filter_map(|p| Some(format!("`{}` at {}", p.name, p.estimate?))).collect();
    (!ended.is_empty())
        .then(|| format!("{}: held at a bound, beyond which the data pull: {}", degree.name, listed(&ended)))
}

fn weak(degree: &DegreeTrust) -> Option<String> {
    let lost = degree.parameters.iter().filter_map(|p| {
        let strength = p.instrument_strength.filter(|s| *s < WEAK)?;
        Some(format!("`{}` {:.0} %", p.term, 100.0 * strength))
    });
    let lost: Vec<String> = lost.collect();
    (!lost.is_empty() && degree.estimator.by_instruments()).then(|| {
        format!("{}: weak instruments: the nominal simulation tells of {}", degree.name, listed(&lost))
    })
}

fn not_white(degree: &DegreeTrust, white: &Whiteness) -> String {
    let allowed = match degree.estimator {
        used if used.searches() => "any correlation within a sub-experiment".to_owned(),
        _ => format!("{} lags", white.lags),
    };
    let wide = !degree.estimator.searches() && white.first_autocorrelation < ALTERNATING;
    format!(
        "{}: residuals are not white (neighbours correlate by {:.2}): the standard errors allow for {allowed}{}",
        degree.name,
        white.first_autocorrelation,
        if wide { ", and are rather too large" } else { "" }
    )
}

/// How far a norm of RMSE/std lies above another over `pairs` (named `called`), with the interval of that median or
/// why there is none.
pub fn lies_above(median: Option<f64>, ends: [Option<f64>; 2], pairs: u64, called: &str) -> String {
    let number = |x: f64| format!("{x:+.3}");
    let interval = match median_interval_in_words(ends, pairs, number) {
        Ok(interval) => format!("95 %: {interval}; {pairs} {called}"),
        Err(why) => why,
    };
    match median {
        Some(median) => format!("its norm of RMSE/std lies {} above ({interval})", number(median)),
        None => format!("one of the two has no error in half of the {pairs} {called} or more ({interval})"),
    }
}
