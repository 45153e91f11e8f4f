use numerics::statistics::{chi_square_tail, normal_tails};
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

/// The largest correlation between residuals and instruments at other times.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CrossCorrelation {
    /// Index of the instrument.
    pub instrument: usize,
    /// Samples by which the instrument precedes the residual; negative if it follows.
    pub lag: i64,
    /// Their correlation.
    pub correlation: f64,
    /// Probability of a larger one among all that were tried, if residuals and instruments were independent (Bartlett's
    /// variance, Šidák's correction).
    pub p_value: f64,
}

/// Residuals Δy − φᵀθ̂ − c of degree of freedom `d`, part by part.
pub fn residuals(parts: &[&Regression], centring: &Centring, solution: &Solution, d: usize) -> Vec<Vec<f64>> {
    let of = |(i, part): (usize, &&Regression)| residuals_of(part, i, centring, solution, d);
    parts.iter().enumerate().map(of).collect()
}

/// The residuals of part `i`.
pub fn residuals_of(
    part: &Regression,
    i: usize,
    centring: &Centring,
    solution: &Solution,
    d: usize,
) -> Vec<f64> {
    let intercept = centring.intercept(i, d, &solution.theta);
    part.degrees[d].residuals(&solution.theta).map(|left| left - intercept).collect()
}

/// Tests residuals for whiteness over `lags` lags; no pairs across parts.
pub fn whiteness(residuals: &[Vec<f64>], lags: usize) -> Whiteness {
    let mut tests = ResidualTests::new(lags, 0);
    residuals.iter().for_each(|part| tests.add(part, &[]));
    tests.whiteness()
}

/// Σ a(k) b(k − lag).
fn lagged(a: &[f64], b: &[f64], lag: usize) -> f64 {
    a.iter().skip(lag).zip(b).map(|(a, b)| a * b).sum()
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

/// The sums for tests of residuals, accumulated part by part.
pub struct ResidualTests {
    samples: usize,
    /// Pairs of each lag within parts.
    pairs: Vec<usize>,
    /// Σ ε².
    power: f64,
    /// Σ ε(k) ε(k − lag) for lags from 1 on.
    own: Vec<f64>,
    signals: Vec<Signal>,
}

impl ResidualTests {
    /// Tests over `lags` lags, against this number of instruments.
    pub fn new(lags: usize, instruments: usize) -> Self {
        // The start value of `Iterator::sum`, so that sums part by part have the same bits.
        let zero: f64 = std::iter::empty::<f64>().sum();
        let signals = (0..instruments).map(|_| Signal::new(lags)).collect();
        Self { samples: 0, pairs: vec![0; lags], power: zero, own: vec![zero; lags], signals }
    }

    /// Adds a part: its residuals, and its instruments without their means.
    pub fn add(&mut self, residuals: &[f64], instruments: &[Vec<f64>]) {
        self.samples += residuals.len();
        residuals.iter().for_each(|e| self.power += e * e);
        for (lag, (pairs, own)) in self.pairs.iter_mut().zip(&mut self.own).enumerate() {
            *pairs += residuals.len().saturating_sub(lag + 1);
            *own += lagged(residuals, residuals, lag + 1);
        }
        self.signals.iter_mut().zip(instruments).for_each(|(signal, zeta)| signal.add(zeta, residuals));
    }

    /// ρ_1 ….
    fn correlations(&self) -> Vec<f64> {
        self.own.iter().map(|at| if self.power > 0.0 { at / self.power } else { 0.0 }).collect()
    }

    /// See [`whiteness`].
    pub fn whiteness(&self) -> Whiteness {
        let correlations = self.correlations();
        let n = self.samples as f64;
        let term = |(rho, pairs): (&f64, &usize)| if *pairs > 0 { rho * rho / *pairs as f64 } else { 0.0 };
        let statistic = n * (n + 2.0) * correlations.iter().zip(&self.pairs).map(term).sum::<f64>();
        Whiteness {
            statistic,
            lags: self.own.len() as u64,
            p_value: chi_square_tail(statistic, self.own.len() as f64),
            first_autocorrelation: correlations.first().copied().unwrap_or(0.0),
        }
    }

    /// Correlates residuals with instruments some samples earlier and later, but not at the same time: there the
    /// estimate makes them orthogonal. `None` if nothing varies.
    pub fn strongest(&self) -> Option<CrossCorrelation> {
        let (own, lags) = (self.correlations(), self.own.len());
        let mut strongest: Option<(f64, CrossCorrelation)> = None;
        for (instrument, signal) in self.signals.iter().enumerate() {
            let size = (self.power * signal.power).sqrt();
            let both = signal.correlations().zip(&own).map(|(a, b)| a * b).sum::<f64>();
            let spread = ((1.0 + 2.0 * both).max(1e-3) / self.samples.max(1) as f64).sqrt();
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
        let tests = (2 * lags * self.signals.len()) as f64;
        strongest.map(|(_, found)| CrossCorrelation { p_value: sidak(found.p_value, tests), ..found })
    }
}

/// 1 − (1 − p)^tests.
fn sidak(p_value: f64, tests: f64) -> f64 {
    -libm::expm1(tests * libm::log1p(-p_value))
}
