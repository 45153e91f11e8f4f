use numerics::statistics::{chi_square_tail, normal_tails};
use numerics::{add_outer, congruence, product, transposed};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use ship::engine::{Compiled, RunView};
use ship::model::Model;

use super::{Centring, PartView, Solution};
use crate::{DegreeSums, Known, Sums};

/// The regressors, instruments and increments of one part.
#[derive(Clone, Debug, PartialEq)]
pub struct Regression {
    /// Number of pairs N.
    pub samples: usize,
    /// Surge, sway, yaw.
    pub degrees: [DegreeRegression; 3],
}

/// Those of one degree of freedom with p parameters.
#[derive(Clone, Debug, PartialEq)]
pub struct DegreeRegression {
    /// p.
    pub parameters: usize,
    /// Regressors φ: N × p, row-major.
    pub phi: Vec<f64>,
    /// Instruments ζ: N × p, row-major.
    pub zeta: Vec<f64>,
    /// Increments Δy less the model's constant and known terms: N.
    pub target: Vec<f64>,
    /// The constraints on the parameters.
    pub known: Known,
}

impl Regression {
    /// Evaluates the terms of `model` over `part`, with its regressors as instruments.
    pub fn of(model: &Model, part: &PartView) -> Self {
        let RunView { measured, exogenous, .. } = part.run;
        let run = RunView { instrument_exogenous: exogenous, ..part.run };
        Self::with(model, &PartView { run, ..*part }, measured)
    }

    /// The same with instruments at `states`, (N+1) × 3.
    pub fn with(model: &Model, part: &PartView, states: &[f64]) -> Self {
        let RunView { measured, exogenous, instrument_exogenous, .. } = part.run;
        let samples = part.run.samples();
        let (phi, zeta) = (terms(model, exogenous, measured), terms(model, instrument_exogenous, states));
        let gains = known_gains(model, exogenous, measured);
        let mut signals = phi.into_iter().zip(zeta);
        let degrees = [0, 1, 2].map(|d| {
            let (phi, zeta) = signals.next().unwrap_or_default();
            let gained = |k: usize| measured[3 * (k + 1) + d] - measured[3 * k + d];
            let increment = |k: usize| gained(k) - gains.get(k).map_or(model.constant[d], |known| known[d]);
            DegreeRegression {
                parameters: model.degrees[d].terms.len(),
                phi,
                zeta,
                target: (0..samples).map(increment).collect(),
                known: Known::of(&model.degrees[d]),
            }
        });
        Self { samples, degrees }
    }

    /// The mean residual Δy − φᵀθ of surge, sway and yaw.
    pub fn left(&self, theta: &[f64]) -> [f64; 3] {
        let mut first = 0;
        self.degrees.each_ref().map(|degree| {
            let slopes = &theta[first..first + degree.parameters];
            first += degree.parameters;
            degree.residuals(slopes).sum::<f64>() / self.samples.max(1) as f64
        })
    }

    /// The same without the first pair. Instruments that start at the measured state share its noise with the first
    /// increment, and with no later one if the noise is white.
    pub fn after_start(mut self) -> Self {
        if self.samples > 0 {
            self.samples -= 1;
            for degree in &mut self.degrees {
                degree.phi.drain(..degree.parameters);
                degree.zeta.drain(..degree.parameters);
                degree.target.remove(0);
            }
        }
        self
    }

    /// A = Σ ζ̃ φ̃ᵀ, b = Σ ζ̃ Δy and the sums of squares.
    pub fn sums(&self) -> Sums {
        Sums {
            samples: self.samples as u64,
            degrees: self.degrees.iter().map(DegreeRegression::sums).collect(),
        }
    }
}

/// The terms of surge, sway and yaw at all `states` but the last: N × p each.
fn terms(model: &Model, exogenous: &[f64], states: &[f64]) -> [Vec<f64>; 3] {
    let (width, samples) = (model.exogenous(), states.len() / 3 - 1);
    let mut compiled = Compiled::new(model, &vec![0.0; model.parameters()]);
    let mut out = model.degrees.each_ref().map(|d| Vec::with_capacity(samples * d.terms.len()));
    for (k, state) in states.as_chunks().0.iter().take(samples).enumerate() {
        compiled.look(*state, &exogenous[width * k..width * (k + 1)], None);
        let mut first = 0;
        for (out, degree) in out.iter_mut().zip(&model.degrees) {
            let range = first..first + degree.terms.len();
            first = range.end;
            out.extend(range.map(|i| compiled.term(i)));
        }
    }
    out
}

/// The increments of surge, sway and yaw due to constant and known terms at all `states` but the last; empty without such terms.
fn known_gains(model: &Model, exogenous: &[f64], states: &[f64]) -> Vec<[f64; 3]> {
    if model.known().next().is_none() {
        return Vec::new();
    }
    let width = model.exogenous();
    let mut compiled = Compiled::new(model, &vec![0.0; model.parameters()]);
    let at = |(k, state): (usize, &[f64; 3])| {
        compiled.look(*state, &exogenous[width * k..width * (k + 1)], None);
        compiled.known()
    };
    let states = states.as_chunks().0;
    states[..states.len() - 1].iter().enumerate().map(at).collect()
}

impl DegreeRegression {
    /// Row k of φ.
    pub fn phi(&self, k: usize) -> &[f64] {
        &self.phi[k * self.parameters..(k + 1) * self.parameters]
    }

    /// Row k of ζ.
    pub fn zeta(&self, k: usize) -> &[f64] {
        &self.zeta[k * self.parameters..(k + 1) * self.parameters]
    }

    /// Δy − φᵀθ of every pair.
    pub fn residuals<'a>(&'a self, theta: &'a [f64]) -> impl Iterator<Item = f64> + 'a {
        let predicted = move |k: usize| self.phi(k).iter().zip(theta).map(|(f, t)| f * t).sum::<f64>();
        self.target.iter().enumerate().map(move |(k, target)| target - predicted(k))
    }

    fn sums(&self) -> DegreeSums {
        let mut sums = DegreeSums { known: self.known.clone(), ..DegreeSums::zero(self.parameters) };
        for (k, increment) in self.target.iter().enumerate() {
            sums.add_sample(self.zeta(k), self.phi(k), 1.0, *increment);
        }
        sums
    }
}

/// How much of each regressor its instruments explain, beyond what they explain of the others: Shea's partial R²
/// (*Review of Economics and Statistics* 79, 1997), (S_φφ⁻¹)_ii / ((S_φζ S_ζζ⁻¹ S_ζφ)⁻¹)_ii of centred sums. 1 for
/// least squares, near 0 for instruments that do not follow the motion. `None` if a matrix is singular.
pub fn strength(parts: &[&Regression], centring: &Centring, d: usize) -> Option<Vec<f64>> {
    let mut strength = Strength::default();
    parts.iter().enumerate().for_each(|(i, part)| strength.add(i, &part.degrees[d], centring, d));
    strength.partial()
}

/// The sums for the strength of instruments.
#[derive(Clone, Debug, Default)]
pub struct Strength {
    /// p, and S_φφ, S_ζζ, S_ζφ.
    sums: Option<(usize, [Vec<f64>; 3])>,
}

impl Strength {
    /// Adds degree of freedom `d` of part number `i`.
    pub fn add(&mut self, i: usize, part: &DegreeRegression, centring: &Centring, d: usize) {
        let p = part.parameters;
        let (_, sums) = self.sums.get_or_insert_with(|| (p, [0; 3].map(|_| vec![0.0; p * p])));
        let (mut zeta, mut phi) = (Vec::new(), Vec::new());
        for k in 0..part.target.len() {
            centring.zeta(i, d, part.zeta(k), &mut zeta);
            centring.phi(i, d, part.phi(k), &mut phi);
            for (sum, (left, right)) in sums.iter_mut().zip([(&phi, &phi), (&zeta, &zeta), (&zeta, &phi)]) {
                add_outer(sum, left, right);
            }
        }
    }

    /// See [`strength`].
    pub fn partial(self) -> Option<Vec<f64>> {
        let (p, sums) = self.sums?;
        let scale: Vec<[f64; 2]> = (0..p).map(|i| [0, 1].map(|s: usize| sums[s][i * p + i].sqrt())).collect();
        let scaled = |which: usize, rows: usize, columns: usize| -> Vec<f64> {
            (0..p * p).map(|k| sums[which][k] / (scale[k / p][rows] * scale[k % p][columns])).collect()
        };
        let (regressors, instruments, mixed) = (scaled(0, 0, 0), scaled(1, 1, 1), scaled(2, 1, 0));
        let mut projected = mixed.clone();
        numerics::solve(p, &mut instruments.clone(), &mut projected)?;
        let explained = product(p, &transposed(p, &mixed), &projected);
        let (total, explained) = (inverse_diagonal(p, &regressors)?, inverse_diagonal(p, &explained)?);
        let partial: Vec<f64> = total
            .iter()
            .zip(&explained)
            .map(|(total, explained)| (total / explained).clamp(0.0, 1.0))
            .collect();
        partial.iter().all(|x| x.is_finite()).then_some(partial)
    }
}

fn inverse_diagonal(p: usize, a: &[f64]) -> Option<Vec<f64>> {
    let (mut destroyed, mut inverse) = (a.to_vec(), vec![0.0; p * p]);
    numerics::inverse(p, &mut destroyed, &mut inverse)?;
    Some((0..p).map(|i| inverse[i * p + i]).collect())
}

/// Bandwidth by the rule of thumb 4 (N/100)^(2/9): Newey & West, *Review of Economic Studies* 61, 1994.
pub fn default_bandwidth(samples: usize) -> usize {
    (4.0 * libm::pow(samples as f64 / 100.0, 2.0 / 9.0)).floor() as usize
}

/// Covariance of θ̂ of degree of freedom `d`, p × p row-major: G B Gᵀ with B = N/(N − p − intercepts) Σ_l w_l Σ_k
/// (g(k) g(k−l)ᵀ), g = ζᶜ ε, the weights w_l = 1 − |l|/(bandwidth + 1) of Bartlett and no lags across parts (Newey &
/// West, *Econometrica* 55, 1987). ζᶜ are the instruments without the removed mean.
pub fn sandwich(
    parts: &[&Regression],
    centring: &Centring,
    solution: &Solution,
    d: usize,
    bandwidth: usize,
) -> Vec<f64> {
    let mut meat = Meat::new(solution.theta.len(), bandwidth);
    for (i, part) in parts.iter().enumerate() {
        let residuals = residuals_of(part, i, centring, solution, d);
        meat.add(&part.degrees[d], &residuals, |row, out| centring.zeta(i, d, row, out));
    }
    meat.covariance(centring, solution, d)
}

/// The meat B while it is accumulated, without its factor.
pub struct Meat {
    p: usize,
    bandwidth: usize,
    samples: usize,
    meat: Vec<f64>,
}

impl Meat {
    /// Of `p` parameters.
    pub fn new(p: usize, bandwidth: usize) -> Self {
        Self { p, bandwidth, samples: 0, meat: vec![0.0; p * p] }
    }

    /// Adds a part with its residuals; `centred` removes the mean from a row of instruments.
    pub fn add(
        &mut self,
        part: &DegreeRegression,
        residuals: &[f64],
        centred: impl Fn(&[f64], &mut Vec<f64>),
    ) {
        self.samples += residuals.len();
        let (mut scores, mut zeta) = (Vec::with_capacity(part.zeta.len()), Vec::new());
        for (k, residual) in residuals.iter().enumerate() {
            centred(part.zeta(k), &mut zeta);
            scores.extend(zeta.iter().map(|z| z * residual));
        }
        add_part(&mut self.meat, &scores, self.p, self.bandwidth);
    }

    /// The covariance of `solution` of degree of freedom `d`.
    pub fn covariance(mut self, centring: &Centring, solution: &Solution, d: usize) -> Vec<f64> {
        let freedom = self.samples.saturating_sub(centring.unknowns(d, &solution.gain, self.p)).max(1);
        self.meat.iter_mut().for_each(|m| *m *= self.samples as f64 / freedom as f64);
        congruence(self.p, &solution.gain, &self.meat)
    }
}

fn add_part(meat: &mut [f64], scores: &[f64], p: usize, bandwidth: usize) {
    let samples = scores.len() / p.max(1);
    for lag in 0..=bandwidth.min(samples.saturating_sub(1)) {
        let weight = 1.0 - lag as f64 / (bandwidth as f64 + 1.0);
        let mut products = vec![0.0; p * p];
        for k in lag..samples {
            let (now, before) = (&scores[k * p..(k + 1) * p], &scores[(k - lag) * p..(k - lag + 1) * p]);
            add_outer(&mut products, now, before);
        }
        for ((entry, product), other) in meat.iter_mut().zip(&products).zip(transposed(p, &products)) {
            *entry += weight * if lag == 0 { *product } else { product + other };
        }
    }
}

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
struct InstrumentSums {
    /// Σ ζ².
    power: f64,
    /// Σ ζ(k) ζ(k − lag) for lags from 1 on.
    lagged_squares: Vec<f64>,
    /// Σ ζ(k − lag) ε(k) for lags from −lags to lags, but for 0.
    crossed: Vec<f64>,
}

impl InstrumentSums {
    fn new(lags: usize) -> Self {
        Self { power: 0.0, lagged_squares: vec![0.0; lags], crossed: vec![0.0; 2 * lags] }
    }

    /// Adds a part: no products across parts.
    fn add(&mut self, zeta: &[f64], residuals: &[f64]) {
        let lags = self.lagged_squares.len();
        zeta.iter().for_each(|z| self.power += z * z);
        for lag in 1..=lags {
            self.lagged_squares[lag - 1] += lagged(zeta, zeta, lag);
            self.crossed[lags - lag] += lagged(zeta, residuals, lag);
            self.crossed[lags + lag - 1] += lagged(residuals, zeta, lag);
        }
    }

    /// ρ_1 ….
    fn correlations(&self) -> impl Iterator<Item = f64> {
        self.lagged_squares.iter().map(|at| if self.power > 0.0 { at / self.power } else { 0.0 })
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
    lagged_squares: Vec<f64>,
    signals: Vec<InstrumentSums>,
}

impl ResidualTests {
    /// Tests over `lags` lags, against this number of instruments.
    pub fn new(lags: usize, instruments: usize) -> Self {
        // The start value of `Iterator::sum`, so that sums part by part have the same bits.
        let zero: f64 = std::iter::empty::<f64>().sum();
        let signals = (0..instruments).map(|_| InstrumentSums::new(lags)).collect();
        Self { samples: 0, pairs: vec![0; lags], power: zero, lagged_squares: vec![zero; lags], signals }
    }

    /// Adds a part: its residuals, and its instruments without their means.
    pub fn add(&mut self, residuals: &[f64], instruments: &[Vec<f64>]) {
        self.samples += residuals.len();
        residuals.iter().for_each(|e| self.power += e * e);
        for (lag, (pairs, sum)) in self.pairs.iter_mut().zip(&mut self.lagged_squares).enumerate() {
            *pairs += residuals.len().saturating_sub(lag + 1);
            *sum += lagged(residuals, residuals, lag + 1);
        }
        self.signals.iter_mut().zip(instruments).for_each(|(signal, zeta)| signal.add(zeta, residuals));
    }

    /// ρ_1 ….
    fn correlations(&self) -> Vec<f64> {
        self.lagged_squares.iter().map(|at| if self.power > 0.0 { at / self.power } else { 0.0 }).collect()
    }

    /// See [`whiteness`].
    pub fn whiteness(&self) -> Whiteness {
        let correlations = self.correlations();
        let n = self.samples as f64;
        let term = |(rho, pairs): (&f64, &usize)| if *pairs > 0 { rho * rho / *pairs as f64 } else { 0.0 };
        let statistic = n * (n + 2.0) * correlations.iter().zip(&self.pairs).map(term).sum::<f64>();
        Whiteness {
            statistic,
            lags: self.lagged_squares.len() as u64,
            p_value: chi_square_tail(statistic, self.lagged_squares.len() as f64),
            first_autocorrelation: correlations.first().copied().unwrap_or(0.0),
        }
    }

    /// Correlates residuals with instruments some samples earlier and later, but not at the same time: there the
    /// estimate makes them orthogonal. `None` if nothing varies.
    pub fn strongest(&self) -> Option<CrossCorrelation> {
        let (correlations, lags) = (self.correlations(), self.lagged_squares.len());
        let mut strongest: Option<(f64, CrossCorrelation)> = None;
        for (instrument, signal) in self.signals.iter().enumerate() {
            let size = (self.power * signal.power).sqrt();
            let both = signal.correlations().zip(&correlations).map(|(a, b)| a * b).sum::<f64>();
            let spread = ((1.0 + 2.0 * both).max(1e-3) / self.samples.max(1) as f64).sqrt();
            if size <= 0.0 {
                continue;
            }
            let tried = (-(lags as i64)..=lags as i64).filter(|lag| *lag != 0);
            for (lag, crossed) in tried.zip(&signal.crossed) {
                let correlation = crossed / size;
                let z = correlation / spread;
                if strongest.as_ref().is_none_or(|(best, _)| z.abs() > *best) {
                    let crossing =
                        CrossCorrelation { instrument, lag, correlation, p_value: normal_tails(z) };
                    strongest = Some((z.abs(), crossing));
                }
            }
        }
        let tests = (2 * lags * self.signals.len()) as f64;
        strongest
            .map(|(_, crossing)| CrossCorrelation { p_value: sidak(crossing.p_value, tests), ..crossing })
    }
}

/// 1 − (1 − p)^tests.
fn sidak(p_value: f64, tests: f64) -> f64 {
    -libm::expm1(tests * libm::log1p(-p_value))
}
