use estimation::one_step_errors;
use estimation::pooled::Covered;
use numerics::statistics::{MeanTrajectory, Z};
use regression::pooled::{Part, PooledRuns, Recorded};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use ship::engine::RunView;
use ship::model::{DegreeOfFreedom, Model, Variable};

use super::simulated::{Contestant, Simulated};

/// Length of a stretch \[s\]: long enough that the motion passes through zero and returns.
pub const STRETCH_S: f64 = 60.0;
/// Smaller relative differences are ignored.
const NONE: f64 = 1e-9;

/// How large the channels were: the range of their root mean squares over stretches of the data, side by side in each run.
///
/// A model holds for motions as large as those that it was fitted to, and as small: a zig-zag of one degree stays inside the
/// ranges of all channels. Of n stretches that are like each other and a new one, the new one is the least or the largest
/// with probability 2/(n + 1) in each channel.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Magnitudes {
    /// Length of a stretch \[s\].
    pub stretch_s: f64,
    /// Their number.
    pub stretches: u64,
    /// Least and largest root mean square: states, inputs, measured disturbances in the model's order. Any of a direction.
    pub channels: Vec<Covered>,
}

/// Stretches of recordings in which the ship moves less or more than in any that the model was fitted to.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Validity {
    /// Length of a stretch \[s\].
    pub stretch_s: f64,
    /// Number of stretches.
    pub stretches: u64,
    /// Those that are outside in some channel.
    pub outside: u64,
    /// The channels that are outside at all.
    pub channels: Vec<Unlike>,
}

/// A channel whose root mean square over a stretch leaves the range of those that the model was fitted to.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Unlike {
    /// The channel.
    pub name: String,
    /// Its unit.
    pub unit: String,
    /// Least root mean square that the model was fitted to.
    pub low: f64,
    /// Largest.
    pub high: f64,
    /// Stretches below.
    pub below: u64,
    /// Stretches above.
    pub above: u64,
}

impl Magnitudes {
    /// The magnitudes of `runs`, whose channels are the variables of `model`, at `rate_hz`; `None` if no run is as
    /// long as a stretch.
    ///
    /// # Errors
    /// Runs that cannot be read.
    pub fn of<R: Recorded>(model: &Model, runs: &PooledRuns<R>, hz: f64) -> Result<Option<Self>, R::Error> {
        let mut ends = vec![[f64::INFINITY, f64::NEG_INFINITY]; model.variables.len()];
        let mut stretches = 0;
        runs.each_source(None, |_, parts| {
            for stretch in parts.iter().flat_map(|part| magnitudes(part.view(), hz)) {
                stretches += 1;
                for ([low, high], value) in ends.iter_mut().zip(stretch) {
                    (*low, *high) = (low.min(value), high.max(value));
                }
            }
        })?;
        let channel = |(i, (variable, [low, high])): (usize, (&Variable, &[f64; 2]))| {
            // A direction of wind or water says nothing of how much the ship moves: any will do.
            let is_direction = i >= 3 + model.inputs && variable.unit == "rad";
            let [low, high] = if is_direction { [0.0, 1e12] } else { [*low, *high] };
            Covered { name: variable.name.clone(), unit: variable.unit.clone(), low, high }
        };
        let channels = model.variables.iter().zip(&ends).enumerate().map(channel).collect();
        Ok((stretches > 0).then_some(Self { stretch_s: STRETCH_S, stretches, channels }))
    }
}

/// Root mean squares of all channels over each whole stretch of `run`.
fn magnitudes(run: RunView, rate_hz: f64) -> impl Iterator<Item = Vec<f64>> {
    let length = ((STRETCH_S * rate_hz).round() as usize).max(1);
    let width = run.exogenous.len() / run.samples().max(1);
    (0..run.samples() / length).map(move |i| {
        let rows = i * length..(i + 1) * length;
        let states = run.measured[3 * rows.start..3 * rows.end].as_chunks::<3>().0;
        let inputs = run.exogenous[width * rows.start..width * rows.end].chunks_exact(width.max(1));
        let mut sums = vec![0.0; 3 + width];
        states.iter().for_each(|row| sums.iter_mut().zip(row).for_each(|(sum, x)| *sum += x * x));
        inputs.for_each(|row| sums[3..].iter_mut().zip(row).for_each(|(sum, x)| *sum += x * x));
        sums.into_iter().map(|sum: f64| (sum / length as f64).sqrt()).collect()
    })
}

impl Validity {
    /// Compares `runs` with `known`; `None` if no run is as long as a stretch.
    pub fn of<'r>(known: &Magnitudes, runs: impl Iterator<Item = RunView<'r>>, rate_hz: f64) -> Option<Self> {
        let unlike = |known: &Covered| {
            let Covered { name, unit, low, high } = known.clone();
            Unlike { name, unit, low, high, below: 0, above: 0 }
        };
        let mut channels: Vec<Unlike> = known.channels.iter().map(unlike).collect();
        let (mut stretches, mut outside) = (0, 0);
        for stretch in runs.flat_map(|run| magnitudes(run, rate_hz)) {
            stretches += 1;
            let mut left = false;
            for (channel, x) in channels.iter_mut().zip(stretch) {
                let (below, above) = (x < channel.low * (1.0 - NONE), x > channel.high * (1.0 + NONE));
                channel.below += u64::from(below);
                channel.above += u64::from(above);
                left |= below || above;
            }
            outside += u64::from(left);
        }
        channels.retain(|channel| channel.below + channel.above > 0);
        (stretches > 0).then_some(Self { stretch_s: STRETCH_S, stretches, outside, channels })
    }

    /// The validity over two sets of runs.
    pub fn together(first: Option<Self>, second: Option<Self>) -> Option<Self> {
        let (Some(mut all), Some(more)) = (first.clone(), second.clone()) else { return first.or(second) };
        all.stretches += more.stretches;
        all.outside += more.outside;
        for channel in more.channels {
            match all.channels.iter_mut().find(|known| known.name == channel.name) {
                Some(known) => {
                    known.below += channel.below;
                    known.above += channel.above;
                }
                None => all.channels.push(channel),
            }
        }
        Some(all)
    }

    /// In words; `None` if all is inside.
    pub fn statement(&self) -> Option<String> {
        let Self { stretch_s, stretches, outside, channels } = self;
        let sides = |Unlike { name, unit, low, high, below, above }: &Unlike| {
            let both = [("below", low, below), ("above", high, above)].into_iter().filter(|side| *side.2 > 0);
            both.map(|(word, bound, count)| format!("{name} {word} {bound:.3e} {unit} in {count}")).collect()
        };
        let all: Vec<String> = channels.iter().flat_map::<Vec<_>, _>(sides).collect();
        (*outside > 0).then(|| {
            format!(
                "outside the range of validity in {outside} of {stretches} stretches of {stretch_s} s, where the ship moves \
                 less or more than in any that the model was fitted to: root mean square of {}",
                all.join(", ")
            )
        })
    }
}

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

/// Correlations for the first contestant: one-step residuals of u, v, r, then free-run errors. Empty if nothing varies.
pub(super) fn error_correlations(
    first: &Contestant,
    sources: &[(String, Vec<Part>)],
    simulations: &Simulated,
    are_inputs_held: bool,
) -> Vec<ErrorCorrelations> {
    let all = || sources.iter().flat_map(|(_, windows)| windows);
    let simulated = all().zip(simulations.windows.iter().flatten());
    let (followed, errors): (Vec<&Part>, Vec<[Vec<f64>; 3]>) = simulated
        .filter_map(|(window, trajectory)| Some((window, free_run(window, &trajectory.as_ref()?.states))))
        .unzip();
    let residuals: Vec<[Vec<f64>; 3]> = all().map(|part| one_step(first, part, are_inputs_held)).collect();
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
        let exogenous = ship.exogenous(window).into_owned();
        let part = Part { exogenous, ..window.clone() };
        let forces = one_step_errors(ship.model, ship.theta, &part, are_inputs_held);
        mean.iter_mut().zip(&forces).for_each(|(mean, force)| mean.add(force));
    }
    mean.map(|mean| mean.mean().to_vec())
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
        let lagged: Vec<Vec<f64>> = errors.iter().map(|window| window[d as usize].clone()).collect();
        let samples: usize = lagged.iter().map(Vec::len).sum();
        let crossed = |(name, input): &(&str, Vec<Vec<f64>>)| {
            let crossed = cross_correlations(&lagged, input, CROSSED)?;
            Some(InputCorrelations { name: (*name).to_owned(), crossed })
        };
        Some(ErrorCorrelations {
            of,
            state: d.state().to_owned(),
            samples: samples as u64,
            bound: Z / (samples as f64).sqrt(),
            own: autocorrelations(&lagged, OWN)?,
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
