use numerics::distributions::{chi_square_tail, normal_tails};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{Centring, Regression, Solution};

/// Ljung and Box's test: whether residuals are white.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Whiteness {
    /// Q = N (N + 2) Σ ρ_l²/(N_l), l = 1 … lags, N_l being the pairs of lag l within sub-experiments.
    pub statistic: f64,
    /// Number of lags, and degrees of freedom.
    pub lags: u64,
    /// Probability of a larger Q of white residuals.
    pub p_value: f64,
    /// Autocorrelation ρ_1 of neighbours.
    pub first_autocorrelation: f64,
}

/// The largest correlation between residuals and instruments at another time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CrossCorrelation {
    /// Index of the instrument.
    pub instrument: usize,
    /// Samples by which the instrument comes earlier; below zero, later.
    pub lag: i64,
    /// Their correlation.
    pub correlation: f64,
    /// Probability of a larger one among all that were tried, if residuals and instruments were independent (Bartlett's
    /// variance, Šidák's correction).
    pub p_value: f64,
}

/// Residuals Δy − φᵀθ̂ − c of degree of freedom `d`, part by part.
pub fn residuals(parts: &[&Regression], centring: &Centring, solution: &Solution, d: usize) -> Vec<Vec<f64>> {
    let of = |(i, part): (usize, &&Regression)| {
        let degree = &part.degrees[d];
        let intercept = centring.intercept(i, d, &solution.theta);
        let predicted = |k: usize| degree.phi(k).iter().zip(&solution.theta).map(|(f, t)| f * t).sum::<f64>();
        degree.target.iter().enumerate().map(|(k, target)| target - predicted(k) - intercept).collect()
    };
    parts.iter().enumerate().map(of).collect()
}

/// Tests residuals for whiteness over `lags` lags; no pairs across parts.
pub fn whiteness(residuals: &[Vec<f64>], lags: usize) -> Whiteness {
    let samples: usize = residuals.iter().map(Vec::len).sum();
    let correlations = correlations(residuals, lags);
    let n = samples as f64;
    let pairs = |lag: usize| residuals.iter().map(|r| r.len().saturating_sub(lag)).sum::<usize>() as f64;
    let term = |(rho, lag): (&f64, usize)| if pairs(lag) > 0.0 { rho * rho / pairs(lag) } else { 0.0 };
    let statistic = n * (n + 2.0) * correlations.iter().zip(1..).map(term).sum::<f64>();
    Whiteness {
        statistic,
        lags: lags as u64,
        p_value: chi_square_tail(statistic, lags as f64),
        first_autocorrelation: correlations.first().copied().unwrap_or(0.0),
    }
}

/// ρ_1 … ρ_lags of a signal in parts.
fn correlations(parts: &[Vec<f64>], lags: usize) -> Vec<f64> {
    let power: f64 = parts.iter().flatten().map(|e| e * e).sum();
    let at = |lag: usize| {
        let part = |x: &Vec<f64>| x.iter().skip(lag).zip(x).map(|(a, b)| a * b).sum::<f64>();
        parts.iter().map(part).sum::<f64>()
    };
    (1..=lags).map(|lag| if power > 0.0 { at(lag) / power } else { 0.0 }).collect()
}

/// Correlates residuals with instruments up to `lags` samples earlier and later, but not at the same time: there the
/// estimate makes them orthogonal. `None` where nothing varies.
pub fn cross_correlation(
    parts: &[&Regression],
    residuals: &[Vec<f64>],
    centring: &Centring,
    d: usize,
    lags: usize,
) -> Option<CrossCorrelation> {
    let own = correlations(residuals, lags);
    let power: f64 = residuals.iter().flatten().map(|e| e * e).sum();
    let samples: usize = residuals.iter().map(Vec::len).sum();
    let p = parts.first()?.degrees[d].parameters;
    let mut strongest: Option<(f64, CrossCorrelation)> = None;
    for instrument in 0..p {
        let signals = column(parts, centring, d, instrument);
        let size = (power * signals.iter().flatten().map(|z| z * z).sum::<f64>()).sqrt();
        let both = correlations(&signals, lags).iter().zip(&own).map(|(a, b)| a * b).sum::<f64>();
        let spread = ((1.0 + 2.0 * both).max(1e-3) / samples.max(1) as f64).sqrt();
        if size <= 0.0 {
            continue;
        }
        let tried = (-(lags as i64)..=lags as i64).filter(|lag| *lag != 0);
        for lag in tried {
            let correlation = at_lag(&signals, residuals, lag) / size;
            let z = correlation / spread;
            if strongest.as_ref().is_none_or(|(best, _)| z.abs() > *best) {
                let found = CrossCorrelation { instrument, lag, correlation, p_value: normal_tails(z) };
                strongest = Some((z.abs(), found));
            }
        }
    }
    let tests = (2 * lags * p) as f64;
    strongest.map(|(_, found)| CrossCorrelation { p_value: sidak(found.p_value, tests), ..found })
}

/// 1 − (1 − p)^tests.
fn sidak(p_value: f64, tests: f64) -> f64 {
    -(tests * (-p_value).ln_1p()).exp_m1()
}

/// Instrument `i` of every part without its mean.
fn column(parts: &[&Regression], centring: &Centring, d: usize, i: usize) -> Vec<Vec<f64>> {
    let mut row = Vec::new();
    let mut of = |(part, regression): (usize, &&Regression)| {
        let mut at = |k: usize| {
            centring.zeta(part, d, regression.degrees[d].zeta(k), &mut row);
            row[i]
        };
        (0..regression.samples).map(&mut at).collect()
    };
    parts.iter().enumerate().map(&mut of).collect()
}

/// Σ ζ(k − lag) ε(k).
fn at_lag(instruments: &[Vec<f64>], residuals: &[Vec<f64>], lag: i64) -> f64 {
    let shift = lag.unsigned_abs() as usize;
    let part = |(z, e): (&Vec<f64>, &Vec<f64>)| -> f64 {
        if lag >= 0 {
            e.iter().skip(shift).zip(z).map(|(e, z)| e * z).sum()
        } else {
            z.iter().skip(shift).zip(e).map(|(z, e)| z * e).sum()
        }
    };
    instruments.iter().zip(residuals).map(part).sum()
}
