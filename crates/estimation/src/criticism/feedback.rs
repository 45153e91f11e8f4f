use numerics::distributions::normal_tails;
use numerics::statistics::median;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use ship::engine::RunView;
use ship::model::Model;

use super::problems::Series;

/// Largest probability, and least correlation, for an input's response to be reported.
const UNLIKELY: f64 = 1e-3;
const WEAK: f64 = 0.1;

/// Innovations of an input are clipped at this many times their median, so that a few steps of a course do not
/// dominate.
const MOST: f64 = 3.0;

/// An input that answers what was measured at the same sample.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Feedback {
    /// The input.
    pub input: String,
    /// The measured state, whose error by prediction it goes with: `u`, `v` or `r`.
    pub state: String,
    /// Correlation of the input's news with that error.
    pub correlation: f64,
    /// Probability of a larger one, of any input and state, where inputs know nothing of the errors.
    pub p_value: f64,
}

/// The input that responds most to the white errors of `series`, if any does. Only its innovations, which its last
/// two values do not predict, are used: white errors can correlate with them only if something responds within the
/// sample. An autopilot with its own sensor responds to the ship's true motion alone, so only to the part of an error
/// that is not noise.
pub(super) fn feedback(model: &Model, runs: &[RunView], series: &Series) -> Option<Feedback> {
    let width = model.exogenous();
    let tests = 3 * model.inputs;
    let mut most: Option<Feedback> = None;
    for input in 0..model.inputs {
        let value = |run: usize, k: usize| runs[run].exogenous[k * width + input];
        let Some(innovations) = innovations(series, value, runs) else { continue };
        for (state, name) in ["u", "v", "r"].into_iter().enumerate() {
            let (mut both, mut own, mut errors, mut n) = (0.0, 0.0, 0.0, 0.0);
            for ((_, white), innovations) in series.iter().zip(&innovations) {
                // White errors begin at sample 1, innovations at sample 2.
                for (a, b) in innovations.iter().zip(&white[state][1..]) {
                    both += a * b;
                    own += a * a;
                    errors += b * b;
                    n += 1.0;
                }
            }
            let correlation = both / (own * errors).sqrt();
            if !correlation.is_finite()
                || most.as_ref().is_some_and(|m| m.correlation.abs() >= correlation.abs())
            {
                continue;
            }
            let p_value = (tests as f64 * normal_tails(correlation * f64::sqrt(n))).min(1.0);
            let input = model.input_variables()[input].name.clone();
            most = Some(Feedback { input, state: name.to_owned(), correlation, p_value });
        }
    }
    most.filter(|found| found.p_value < UNLIKELY && found.correlation.abs() > WEAK)
}

/// Innovations of an input per run of `series`, from sample 2 on: what its last two values do not predict; `None` if
/// they always predict it.
fn innovations(
    series: &Series,
    value: impl Fn(usize, usize) -> f64,
    runs: &[RunView],
) -> Option<Vec<Vec<f64>>> {
    let row = |run: usize, k: usize| [value(run, k - 1), value(run, k - 2), 1.0];
    let (mut normal, mut gradient) = ([0.0; 9], [0.0; 3]);
    let mut squares = 0.0;
    for (run, _) in series {
        for k in 2..runs[*run].samples() {
            let (row, y) = (row(*run, k), value(*run, k));
            numerics::add_outer(&mut normal, &row, &row);
            gradient.iter_mut().zip(row).for_each(|(sum, x)| *sum += x * y);
            squares += y * y;
        }
    }
    let mut foretold = gradient;
    // Inputs that hardly vary are predicted well enough by one of the two.
    (0..3).for_each(|i| normal[4 * i] *= 1.0 + 1e-9);
    numerics::solve(3, &mut normal, &mut foretold)?;
    let of = |run: usize, k: usize| value(run, k) - numerics::dot(&foretold, &row(run, k));
    let all: Vec<Vec<f64>> =
        series.iter().map(|(run, _)| (2..runs[*run].samples()).map(|k| of(*run, k)).collect()).collect();
    let left: f64 = all.iter().flatten().map(|x| x * x).sum();
    let typical = median(all.iter().flatten().map(|x| x.abs()).collect())?;
    let held = |x: f64| x.clamp(-MOST * typical, MOST * typical);
    let all = all.into_iter().map(|own| own.into_iter().map(held).collect()).collect();
    (left > 1e-12 * squares && typical > 0.0).then_some(all)
}
