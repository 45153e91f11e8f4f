use numerics::statistics::median_interval_in_words;
use refusal::listed;
use regression::pooled::{COLLINEAR, Whiteness};
use ship::model::ParameterLayout;

use super::{DegreeTrust, Delivered};

/// Instruments are weak if they explain less than this share of a regressor.
const WEAK: f64 = 0.1;
const UNLIKELY: f64 = 0.01;

/// Increments of noise correlate by −0.5: below this correlation standard errors are too large.
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

/// How far a norm of RMSE/std lies above another over `pairs` (named `called`), with that median's interval.
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

/// From this correlation on two estimates are hard to distinguish, and from the next on they cannot be.
const HARD: f64 = 0.95;
const INSEPARABLE: f64 = 0.99;
/// An estimate with a smaller relative error needs no warning, whatever its correlations.
const KNOWN: f64 = 0.05;
const MOST: usize = 4;

struct Pair<'a> {
    names: [&'a str; 2],
    values: [f64; 2],
    errors: [f64; 2],
    correlation: f64,
}

/// The pairs of estimates of `delivered`, whose model with intercepts has this `layout`, that correlate most: a sentence
/// each with the accuracy of both, and of their best combination.
pub fn collinear(delivered: &Delivered, layout: ParameterLayout) -> Vec<String> {
    let mut pairs = pairs(delivered, layout);
    pairs.sort_by(|a, b| b.correlation.abs().total_cmp(&a.correlation.abs()));
    let sentences = pairs.iter().take(MOST).map(Pair::sentence);
    let others = pairs.len().saturating_sub(MOST);
    let counted = format!("{others} further pairs of estimates correlate by {HARD} or more");
    sentences.chain((others > 0).then_some(counted)).collect()
}

fn pairs(delivered: &Delivered, layout: ParameterLayout) -> Vec<Pair<'_>> {
    let Some(covariance) = &delivered.covariance else { return Vec::new() };
    let names = &covariance.names;
    let values = match names.len() == delivered.theta.len() {
        true => delivered.theta.clone(),
        false => layout.woven(&delivered.theta, delivered.constant),
    };
    let entry = |i: usize, j: usize| covariance.entries[i * names.len() + j];
    let errors: Vec<f64> = (0..names.len()).map(|i| entry(i, i).max(0.0).sqrt()).collect();
    let known = (0..values.len().min(names.len())).filter(|i| errors[*i] > 0.0).collect::<Vec<_>>();
    let both = known.iter().flat_map(|j| known.iter().take_while(move |i| *i < j).map(move |i| [*i, *j]));
    let pair = |at: [usize; 2]| Pair {
        names: at.map(|i| names[i].as_str()),
        values: at.map(|i| values[i]),
        errors: at.map(|i| errors[i]),
        correlation: entry(at[0], at[1]) / (errors[at[0]] * errors[at[1]]),
    };
    both.map(pair).filter(Pair::matters).collect()
}

impl Pair<'_> {
    fn matters(&self) -> bool {
        self.correlation.abs() >= HARD && self.relative().into_iter().all(|error| error > KNOWN)
    }

    /// Standard errors over moduli.
    fn relative(&self) -> [f64; 2] {
        [0, 1].map(|i: usize| self.errors[i] / self.values[i].abs())
    }

    /// The multiple of number `other` that leaves the least error when it is added to number `one`, and that sum's standard
    /// error over its modulus: a + λ b with λ = −ρ σ_a/σ_b has the standard error σ_a √(1 − ρ²).
    fn common(&self, [one, other]: [usize; 2]) -> (f64, f64) {
        let factor = -self.correlation * self.errors[one] / self.errors[other];
        let error = self.errors[one] * (1.0 - self.correlation.powi(2)).max(0.0).sqrt();
        (factor, error / (self.values[one] + factor * self.values[other]).abs())
    }

    fn sentence(&self) -> String {
        let ([a, b], [first, second]) = (self.names, self.relative().map(percent));
        let verdict = if self.correlation.abs() >= INSEPARABLE { "cannot" } else { "can hardly" };
        let apart = format!(
            "`{a}` and `{b}` {verdict} be told apart: correlation {:.3}, each alone is known to {first} and {second}",
            self.correlation
        );
        let sums = [[0, 1], [1, 0]].map(|way| self.sum(way));
        let best = sums.into_iter().chain([self.ratio()]).min_by(|a, b| a.1.total_cmp(&b.1));
        match best.filter(|(_, error)| self.relative().into_iter().all(|alone| *error < alone)) {
            Some((what, error)) => format!("{apart}, {what} to {}", percent(error)),
            None => apart,
        }
    }

    /// The sum of number `one` and the best multiple of number `other`, and how well it is known.
    fn sum(&self, [one, other]: [usize; 2]) -> (String, f64) {
        let (factor, error) = self.common([one, other]);
        let sign = if factor < 0.0 { '−' } else { '+' };
        let (one, other, factor) = (self.names[one], self.names[other], three(factor.abs()));
        (format!("`{one}` {sign} {factor} `{other}`"), error)
    }

    /// The ratio, and its standard error over its modulus to first order: √(r_a² + r_b² − 2ρ r_a r_b) with the signed relative
    /// errors r = σ/θ.
    fn ratio(&self) -> (String, f64) {
        let [a, b] = [0, 1].map(|i: usize| self.errors[i] / self.values[i]);
        let square = a * a + b * b - 2.0 * self.correlation * a * b;
        (format!("`{}`/`{}`", self.names[0], self.names[1]), square.max(0.0).sqrt())
    }
}

fn three(value: f64) -> String {
    let exponent = format!("{value:e}").rsplit('e').next().and_then(|e| e.parse::<i32>().ok()).unwrap_or(0);
    match exponent {
        -3..=2 => format!("{value:.*}", usize::try_from(2 - exponent).unwrap_or(0)),
        _ => format!("{value:.2e}"),
    }
}

fn percent(share: f64) -> String {
    let percent = 100.0 * share;
    if percent < 10.0 { format!("{percent:.1} %") } else { format!("{percent:.0} %") }
}
