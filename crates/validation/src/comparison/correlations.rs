use numerics::statistics::{MeanTrajectory, Z};
use regression::pooled::{Part, Regression};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use ship::engine::Replayed;
use ship::model::DegreeOfFreedom;

use super::simulated::{Contestant, Ship, Simulated};

/// Number of lags of autocorrelations.
const OWN: usize = 40;
/// Number of lags of correlations with inputs, in either direction.
const CROSSED: usize = 20;
refusal::choices! {
    /// What a model's errors are errors of.
    pub enum ErrorKind {
        /// Of a prediction from the state measured a sample before. Of measured states it is a moving average by construction:
        /// the noise of a sample enters two increments.
        OneStep = "one-step residual",
        /// Of a free simulation from the first measured state.
        FreeRun = "free-run error",
    }
}

/// How errors of one state correlate with themselves and with inputs at other times. Means over all windows are taken out; no
/// pairs across windows.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ErrorCorrelations {
    /// Of what.
    pub of: ErrorKind,
    /// `u`, `v` or `r`.
    pub state: String,
    /// Number of errors.
    pub samples: u64,
    /// 1.96/√samples: 95 % of the correlations of white errors lie within ± this.
    pub bound: f64,
    /// With themselves 1, 2, … samples before.
    pub own: Vec<f64>,
    /// With the inputs and measured disturbances that vary.
    pub inputs: Vec<InputCorrelations>,
}

/// How errors correlate with one input.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct InputCorrelations {
    /// Its name.
    pub name: String,
    /// With the input −n … n samples before the step that the error ends; below 0 after it. As many on both sides.
    pub crossed: Vec<f64>,
}

/// Correlations for the first contestant: one-step residuals of u, v, r, then free-run errors. Empty if nothing
/// varies.
pub(super) fn error_correlations(
    first: &Contestant,
    sources: &[(String, Vec<Part>)],
    found: &Simulated,
    are_inputs_held: bool,
) -> Vec<ErrorCorrelations> {
    let all = || sources.iter().flat_map(|(_, windows)| windows);
    let simulated = all().zip(found.windows.iter().flatten());
    let (followed, errors): (Vec<&Part>, Vec<[Vec<f64>; 3]>) = simulated
        .filter_map(|(window, found)| Some((window, free_run(window, &found.as_ref()?.states))))
        .unzip();
    let residuals: Vec<[Vec<f64>; 3]> =
        all().map(|window| one_step(first, window, are_inputs_held)).collect();
    let windows: Vec<&Part> = all().collect();
    let one_step = of_states(first, ErrorKind::OneStep, &windows, &residuals);
    one_step.into_iter().chain(of_states(first, ErrorKind::FreeRun, &followed, &errors)).collect()
}

/// Errors of u, v, r at samples 1 to N.
fn free_run(window: &Part, states: &[f64]) -> [Vec<f64>; 3] {
    let (measured, simulated) = (window.measured.as_chunks::<3>().0, states.as_chunks::<3>().0);
    let pairs = || measured.iter().zip(simulated).skip(1);
    [0, 1, 2].map(|d: usize| pairs().map(|(measured, simulated)| measured[d] - simulated[d]).collect())
}

/// Errors of the mean prediction.
fn one_step(first: &Contestant, window: &Part, are_inputs_held: bool) -> [Vec<f64>; 3] {
    let mut mean = [(); 3].map(|()| MeanTrajectory::default());
    for ship in &first.ships {
        let own = residuals(ship, window, are_inputs_held);
        mean.iter_mut().zip(&own).for_each(|(mean, own)| mean.add(own));
    }
    mean.map(|mean| mean.mean().to_vec())
}

/// Δy − φᵀθ of surge, sway and yaw; of forces what their step leaves of the next measured state.
fn residuals(ship: &Ship, window: &Part, are_inputs_held: bool) -> [Vec<f64>; 3] {
    let exogenous = ship.exogenous(window);
    if let Some(moved) = &ship.model.forces {
        let course = (&*exogenous, ship.model.exogenous().max(1));
        let replayed = Replayed::new(moved, ship.theta, course, are_inputs_held);
        let states = window.measured.as_chunks::<3>().0;
        let left = |k: usize, d: usize| states[k + 1][d] - replayed.step(k, states[k])[d];
        return [0, 1, 2].map(|d| (0..window.samples()).map(|k| left(k, d)).collect());
    }
    let part = Part { exogenous: exogenous.into_owned(), ..window.clone() };
    let (regression, layout) = (Regression::of(ship.model, &part.whole()), ship.model.layout());
    [0, 1, 2].map(|d: usize| regression.degrees[d].residuals(&ship.theta[layout.terms(d)]).collect())
}

fn of_states(
    first: &Contestant,
    of: ErrorKind,
    windows: &[&Part],
    errors: &[[Vec<f64>; 3]],
) -> Vec<ErrorCorrelations> {
    let Some(ship) = first.widest() else { return Vec::new() };
    let channel = |i: usize| -> Vec<Vec<f64>> {
        let width = |w: &Part| w.exogenous.len() / w.samples().max(1);
        let place = ship.columns.map_or(i, |columns| columns[i]);
        let of = |w: &&Part| w.exogenous.iter().skip(place).step_by(width(w).max(1)).copied().collect();
        windows.iter().map(of).collect()
    };
    let variables = &ship.model.variables[3..];
    let inputs: Vec<(&str, Vec<Vec<f64>>)> =
        variables.iter().enumerate().map(|(i, variable)| (variable.name.as_str(), channel(i))).collect();
    let state = |d: DegreeOfFreedom| {
        let own: Vec<Vec<f64>> = errors.iter().map(|window| window[d as usize].clone()).collect();
        let samples: usize = own.iter().map(Vec::len).sum();
        let crossed = |(name, input): &(&str, Vec<Vec<f64>>)| {
            let crossed = cross_correlations(&own, input, CROSSED)?;
            Some(InputCorrelations { name: (*name).to_owned(), crossed })
        };
        Some(ErrorCorrelations {
            of,
            state: d.state().to_owned(),
            samples: samples as u64,
            bound: Z / (samples as f64).sqrt(),
            own: autocorrelations(&own, OWN)?,
            inputs: inputs.iter().filter_map(crossed).collect(),
        })
    };
    DegreeOfFreedom::ALL.into_iter().filter_map(state).collect()
}

/// ρ_l = Σ e(k) e(k − l) / Σ e(k)², l = 1 … `lags` but below the longest window's length, e without its mean over all
/// windows; `None` if e does not vary.
pub fn autocorrelations(windows: &[Vec<f64>], lags: usize) -> Option<Vec<f64>> {
    let centred = centred(windows);
    let power = lagged(&centred, &centred, 0);
    let lags = lags.min(longest(windows).saturating_sub(1));
    varies(power).then(|| (1..=lags).map(|lag| lagged(&centred, &centred, lag) / power).collect())
}

/// Σ e(k) x(k − l) / √(Σ e² Σ x²), l = −n … n with n = `lags` but below the longest window's length, both without
/// their means over all windows; `None` if one does not vary.
pub fn cross_correlations(errors: &[Vec<f64>], inputs: &[Vec<f64>], lags: usize) -> Option<Vec<f64>> {
    let (errors, inputs) = (centred(errors), centred(inputs));
    let powers = [&errors, &inputs].map(|all| lagged(all, all, 0));
    let lags = lags.min(longest(&errors).saturating_sub(1));
    let size = (powers[0] * powers[1]).sqrt();
    let later = (1..=lags).rev().map(|lag| lagged(&inputs, &errors, lag) / size);
    let earlier = (0..=lags).map(|lag| lagged(&errors, &inputs, lag) / size);
    powers.into_iter().all(varies).then(|| later.chain(earlier).collect())
}

fn varies(power: f64) -> bool {
    power.is_finite() && power > 0.0
}

fn longest(windows: &[Vec<f64>]) -> usize {
    windows.iter().map(Vec::len).max().unwrap_or(0)
}

fn centred(windows: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let all = || windows.iter().flatten();
    let mean = all().sum::<f64>() / all().count().max(1) as f64;
    windows.iter().map(|window| window.iter().map(|x| x - mean).collect()).collect()
}

/// Σ a(k) b(k − lag) within windows.
fn lagged(a: &[Vec<f64>], b: &[Vec<f64>], lag: usize) -> f64 {
    let window = |(a, b): (&Vec<f64>, &Vec<f64>)| a.iter().skip(lag).zip(b).map(|(a, b)| a * b).sum::<f64>();
    a.iter().zip(b).map(window).sum()
}
