use numerics::statistics::median;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::{Channels, Grid, Series, body_velocity, local_quadratic};

/// Samples of the parabolas that noise is measured against.
const WINDOW: usize = 11;

/// Share of a sample's own noise that the parabola through 11 samples follows at its centre: 89/429.
const FOLLOWED: f64 = 89.0 / 429.0;

/// Standard deviation of normal noise from the median of its modulus.
const FROM_MEDIAN: f64 = 1.482_602_218_505_602;

/// Robust standard deviation of what a parabola through 11 neighbours leaves of a channel, in its unit: white noise as it
/// is, whatever moves slower than some 11 samples not at all. None for pieces without gaps of fewer than 11 samples.
pub fn noise_std(series: &Series) -> Option<f64> {
    let mut residuals: Vec<f64> = Vec::new();
    for piece in series.pieces().into_iter().filter(|piece| piece.len() >= WINDOW) {
        let values = &series.values[piece.clone()];
        let (mut smooth, _) = local_quadratic(&series.t[piece], values, WINDOW);
        let centred = WINDOW / 2..values.len() - WINDOW / 2;
        smooth.iter_mut().zip(values).for_each(|(smooth, value)| *smooth = (value - *smooth).abs());
        residuals.extend(&smooth[centred]);
    }
    let median = median(residuals)?;
    Some(FROM_MEDIAN * median / (1.0 - FOLLOWED).sqrt())
}

/// Median distance from the median; 0 for no values.
fn robust_deviation(values: Vec<f64>) -> f64 {
    let centre = median(values.clone()).unwrap_or(0.0);
    median(values.iter().map(|value| (value - centre).abs()).collect()).unwrap_or(0.0)
}

/// One channel of a recording.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ChannelSummary {
    /// Its name.
    pub name: String,
    /// Its unit.
    pub unit: String,
    /// The inverse of the median step.
    pub rate_hz: Option<f64>,
    /// Rows without a value.
    pub missing: u64,
    /// Gaps longer than `max_gap_s`.
    pub gaps: u64,
    /// Robust standard deviation of what parabolas through 11 neighbours leave.
    pub noise: Option<f64>,
    /// Smallest value.
    pub min: Option<f64>,
    /// Largest value.
    pub max: Option<f64>,
}

/// A measured velocity beside the derivative of position or heading.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MotionSummary {
    /// The velocity.
    pub state: State,
    /// Root mean square of measured − derivative.
    pub rms: f64,
    /// Robust standard deviation of measured − derivative: where it is far below `rms`, a few jumps of the position make up
    /// most of that.
    pub robust_std: f64,
    /// Mean of measured − derivative.
    pub bias: f64,
    /// By how much the measured velocity is late; null where there is too little motion to tell. Where a filter and no pure
    /// delay is behind it, it depends on `velocities.window_s`.
    pub lag_s: Option<f64>,
    /// Slope of the line of measured over derivative, 1 where both are in the same unit; null where they are not correlated.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gain: Option<f64>,
}

vessel::choices! {
    /// A velocity.
    pub enum State {
        /// Surge.
        U = "u",
        /// Sway.
        V = "v",
        /// Yaw rate.
        R = "r",
    }
}

/// Correlation from which a measured velocity and a derivative are taken to be the same motion.
const TOLD: f64 = 0.95;

/// Highest rate at which velocities are compared \[Hz\].
const COMPARED_HZ: f64 = 20.0;

/// Longest lag that is looked for \[s\].
const LONGEST_LAG_S: f64 = 5.0;

/// Compares measured surge, sway and yaw rate with the derivatives of position and heading, taken from parabolas over
/// `window_s`. None where either is not measured or they never meet.
pub fn consistency(channels: &Channels, window_s: f64) -> [Option<MotionSummary>; 3] {
    let smoothed = |name: &str| channels.get(name).map(|series| series.smoothed(window_s));
    let slope = |name: &str| smoothed(name).map(|(_, slope)| slope);
    let Some((psi, r)) = smoothed("psi") else { return [None; 3] };
    let over_ground = slope("x").zip(slope("y")).map(|(north, east)| [north, east]);
    [("y_u", State::U), ("y_v", State::V), ("y_r", State::R)].map(|(name, state)| {
        let measured = channels.get(name)?;
        let rate_hz = measured.rate_hz()?.min(COMPARED_HZ);
        let times = times_of(measured, rate_hz);
        let derivative = match (state, &over_ground) {
            (State::R, _) => r.at(&times),
            (_, Some([north, east])) => {
                let body = north.at(&times).into_iter().zip(east.at(&times)).zip(psi.at(&times));
                body.map(|((n, e), psi)| body_velocity([n, e], psi)[state as usize]).collect()
            }
            (_, None) => return None,
        };
        compare(state, &measured.at(&times), &derivative, rate_hz)
    })
}

/// Times at `rate_hz` in the pieces without gaps, and one in the middle of each gap, where nothing is known.
fn times_of(series: &Series, rate_hz: f64) -> Vec<f64> {
    let mut times = Vec::new();
    for piece in series.pieces() {
        let (first, last) = (series.t[piece.start], series.t[piece.end - 1]);
        if piece.start > 0 {
            times.push(0.5 * (series.t[piece.start - 1] + first));
        }
        times.extend(Grid::new(first, last, rate_hz).times());
    }
    times
}

fn compare(state: State, measured: &[f64], derivative: &[f64], rate_hz: f64) -> Option<MotionSummary> {
    let pairs: Vec<(f64, f64)> = measured.iter().copied().zip(derivative.iter().copied()).collect();
    let known = |pair: &(f64, f64)| pair.0.is_finite() && pair.1.is_finite();
    let differences: Vec<f64> = pairs.iter().filter(|pair| known(pair)).map(|(m, d)| m - d).collect();
    if differences.is_empty() {
        return None;
    }
    let mean =
        |f: &dyn Fn(f64) -> f64| differences.iter().map(|d| f(*d)).sum::<f64>() / differences.len() as f64;
    let (rms, bias) = (mean(&|d| d * d).sqrt(), mean(&|d| d));
    let longest = pairs.split(|pair| !known(pair)).max_by_key(|piece| piece.len()).unwrap_or_default();
    let (measured, derivative): (Vec<f64>, Vec<f64>) = longest.iter().copied().unzip();
    Some(MotionSummary {
        state,
        rms,
        robust_std: FROM_MEDIAN * robust_deviation(differences),
        bias,
        lag_s: lag(&measured, &derivative, rate_hz, LONGEST_LAG_S),
        gain: gain(&measured, &derivative),
    })
}

/// See [`MotionSummary::gain`].
fn gain(measured: &[f64], derivative: &[f64]) -> Option<f64> {
    let n = derivative.len() as f64;
    let mean = derivative.iter().sum::<f64>() / n;
    let squares: f64 = derivative.iter().map(|d| (d - mean) * (d - mean)).sum();
    let products: f64 = measured.iter().zip(derivative).map(|(m, d)| m * (d - mean)).sum();
    (correlation(measured, derivative) > TOLD).then(|| products / squares)
}

/// By how much `measured` comes after `reference` \[s\]; both at `rate_hz`, equally long. The shift within ±`longest_s` (and
/// a quarter of the length) with the highest correlation coefficient over what then overlaps, refined by the parabola
/// through it and its neighbours. None where the coefficient stays below 0.5 or is highest at the longest shift: then there
/// is no motion to tell it from.
pub fn lag(measured: &[f64], reference: &[f64], rate_hz: f64, longest_s: f64) -> Option<f64> {
    let longest = ((longest_s * rate_hz).round() as usize).min(measured.len() / 4) as isize;
    let coefficient = |shift: isize| {
        let overlap = measured.len() - shift.unsigned_abs();
        let late = shift.max(0) as usize;
        let early = (-shift).max(0) as usize;
        correlation(&measured[late..late + overlap], &reference[early..early + overlap])
    };
    let coefficients: Vec<f64> = (-longest..=longest).map(coefficient).collect();
    let (peak, highest) = coefficients.iter().enumerate().max_by(|a, b| a.1.total_cmp(b.1))?;
    if *highest < 0.5 || peak == 0 || peak + 1 == coefficients.len() {
        return None;
    }
    let [before, after] = [coefficients[peak - 1], coefficients[peak + 1]];
    let bend = before - 2.0 * highest + after;
    let refined = if bend < 0.0 { 0.5 * (before - after) / bend } else { 0.0 };
    Some((peak as f64 - longest as f64 + refined) / rate_hz)
}

/// Pearson's coefficient; 0 where either is constant.
fn correlation(a: &[f64], b: &[f64]) -> f64 {
    let n = a.len() as f64;
    let (mean_a, mean_b) = (a.iter().sum::<f64>() / n, b.iter().sum::<f64>() / n);
    let (mut aa, mut bb, mut ab) = (0.0, 0.0, 0.0);
    for (a, b) in a.iter().zip(b) {
        let (a, b) = (a - mean_a, b - mean_b);
        aa += a * a;
        bb += b * b;
        ab += a * b;
    }
    let norm = (aa * bb).sqrt();
    if norm > 0.0 { ab / norm } else { 0.0 }
}
