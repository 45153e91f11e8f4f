use numerics::distributions::{chi_square_tail, normal_tails};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{Centring, Regression, Regressions, Solution};

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
pub fn residuals(
    parts: &dyn Regressions,
    centring: &Centring,
    solution: &Solution,
    d: usize,
) -> Vec<Vec<f64>> {
    let mut all = Vec::new();
    parts.each(&mut |i, part| all.push(residuals_of(part, i, centring, solution, d)));
    all
}

/// Those of part number `i`.
pub(super) fn residuals_of(
    part: &Regression,
    i: usize,
    centring: &Centring,
    solution: &Solution,
    d: usize,
) -> Vec<f64> {
    let degree = &part.degrees[d];
    let intercept = centring.intercept(i, d, &solution.theta);
    let predicted = |k: usize| degree.phi(k).iter().zip(&solution.theta).map(|(f, t)| f * t).sum::<f64>();
    degree.target.iter().enumerate().map(|(k, target)| target - predicted(k) - intercept).collect()
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

/// Σ a(k) b(k − lag).
fn lagged(a: &[f64], b: &[f64], lag: usize) -> f64 {
    a.iter().skip(lag).zip(b).map(|(a, b)| a * b).sum()
}

/// ρ_1 … ρ_lags of a signal in parts.
fn correlations(parts: &[Vec<f64>], lags: usize) -> Vec<f64> {
    let power: f64 = parts.iter().flatten().map(|e| e * e).sum();
    let at = |lag: usize| parts.iter().map(|x| lagged(x, x, lag)).sum::<f64>();
    (1..=lags).map(|lag| if power > 0.0 { at(lag) / power } else { 0.0 }).collect()
}

/// Sums of an instrument without its mean, and of its products with residuals.
struct Signal {
    /// Σ ζ².
    power: f64,
    /// Σ ζ(k) ζ(k − lag) for lags from 1 on.
    own: Vec<f64>,
    /// Σ ζ(k − lag) ε(k) for lags from −lags to lags, but for 0.
    crossed: Vec<f64>,
}

impl Signal {
    fn new(lags: usize) -> Self {
        Self { power: 0.0, own: vec![0.0; lags], crossed: vec![0.0; 2 * lags] }
    }

    /// Adds a part: no products across parts.
    fn add(&mut self, zeta: &[f64], residuals: &[f64]) {
        let lags = self.own.len();
        zeta.iter().for_each(|z| self.power += z * z);
        for lag in 1..=lags {
            self.own[lag - 1] += lagged(zeta, zeta, lag);
            self.crossed[lags - lag] += lagged(zeta, residuals, lag);
            self.crossed[lags + lag - 1] += lagged(residuals, zeta, lag);
        }
    }

    /// ρ_1 ….
    fn correlations(&self) -> impl Iterator<Item = f64> {
        self.own.iter().map(|at| if self.power > 0.0 { at / self.power } else { 0.0 })
    }
}

/// Correlates residuals with instruments up to `lags` samples earlier and later, but not at the same time: there the
/// estimate makes them orthogonal. `None` where nothing varies.
pub fn cross_correlation(
    parts: &dyn Regressions,
    residuals: &[Vec<f64>],
    centring: &Centring,
    d: usize,
    lags: usize,
) -> Option<CrossCorrelation> {
    let own = correlations(residuals, lags);
    let power: f64 = residuals.iter().flatten().map(|e| e * e).sum();
    let samples: usize = residuals.iter().map(Vec::len).sum();
    let signals = signals(parts, residuals, centring, d, lags);
    let mut strongest: Option<(f64, CrossCorrelation)> = None;
    for (instrument, signal) in signals.iter().enumerate() {
        let size = (power * signal.power).sqrt();
        let both = signal.correlations().zip(&own).map(|(a, b)| a * b).sum::<f64>();
        let spread = ((1.0 + 2.0 * both).max(1e-3) / samples.max(1) as f64).sqrt();
        if size <= 0.0 {
            continue;
        }
        let tried = (-(lags as i64)..=lags as i64).filter(|lag| *lag != 0);
        for (lag, crossed) in tried.zip(&signal.crossed) {
            let correlation = crossed / size;
            let z = correlation / spread;
            if strongest.as_ref().is_none_or(|(best, _)| z.abs() > *best) {
                let found = CrossCorrelation { instrument, lag, correlation, p_value: normal_tails(z) };
                strongest = Some((z.abs(), found));
            }
        }
    }
    let tests = (2 * lags * signals.len()) as f64;
    strongest.map(|(_, found)| CrossCorrelation { p_value: sidak(found.p_value, tests), ..found })
}

/// 1 − (1 − p)^tests.
fn sidak(p_value: f64, tests: f64) -> f64 {
    -libm::expm1(tests * libm::log1p(-p_value))
}

/// All instruments of degree of freedom `d`.
fn signals(
    parts: &dyn Regressions,
    residuals: &[Vec<f64>],
    centring: &Centring,
    d: usize,
    lags: usize,
) -> Vec<Signal> {
    let (mut signals, mut row) = (Vec::new(), Vec::new());
    parts.each(&mut |i, part| {
        let degree = &part.degrees[d];
        let mut columns = vec![Vec::with_capacity(part.samples); degree.parameters];
        for k in 0..part.samples {
            centring.zeta(i, d, degree.zeta(k), &mut row);
            columns.iter_mut().zip(&row).for_each(|(column, z)| column.push(*z));
        }
        signals.resize_with(degree.parameters, || Signal::new(lags));
        signals.iter_mut().zip(&columns).for_each(|(signal, zeta)| signal.add(zeta, &residuals[i]));
    });
    signals
}
