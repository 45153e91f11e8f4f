use std::ops::Range;

use numerics::statistics::streamed_median;
use refusal::Invalid;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::samples::{Samples, View};
use crate::{Channels, Grid, Series, Setup, body_velocity, local_quadratic};

/// Samples of the parabolas that noise is measured from.
const WINDOW: usize = 11;

/// Share of a sample's own noise that the parabola through 11 samples follows at its centre: 89/429.
const FOLLOWED: f64 = 89.0 / 429.0;

/// Standard deviation of normal noise from the median of its modulus.
const FROM_MEDIAN: f64 = 1.482_602_218_505_602;

/// Robust standard deviation of a channel's residuals from parabolas through 11 neighbours, in its unit: it contains white
/// noise in full, and nothing that moves more slowly than some 11 samples. `None` if no section without gaps has 11 samples.
pub fn noise_std(series: &Series) -> Option<f64> {
    let mut residuals = series.values.none();
    for section in series.sections().into_iter().filter(|section| section.len() >= WINDOW) {
        let centred = WINDOW / 2..section.len() - WINDOW / 2;
        let mut values = series.values.range(section.clone()).enumerate();
        local_quadratic(&series.t, &series.values, section, WINDOW, |smooth, _| {
            if let Some((_, value)) = values.next().filter(|(i, _)| centred.contains(i)) {
                residuals.push((value - smooth).abs());
            }
        });
    }
    let median = streamed_median(|| residuals.iter())?;
    Some(FROM_MEDIAN * median / (1.0 - FOLLOWED).sqrt())
}

/// Median distance from the median; 0 for no values.
fn robust_deviation(values: &Samples) -> f64 {
    let centre = streamed_median(|| values.iter()).unwrap_or(0.0);
    streamed_median(|| values.iter().map(|value| (value - centre).abs())).unwrap_or(0.0)
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
    /// Slope of the line of measured over derivative, 1 where both are in the same unit and count alike; null where they are not correlated.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gain: Option<f64>,
}

refusal::choices! {
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
const SAME_MOTION: f64 = 0.95;

/// Highest rate at which velocities are compared \[Hz\].
const COMPARED_HZ: f64 = 20.0;

/// Longest lag that is searched \[s\].
const LONGEST_LAG_S: f64 = 5.0;

/// The derivatives of position and heading, from parabolas over a window.
pub(crate) struct Derivatives {
    /// The heading, smoothed \[rad\].
    pub(crate) psi: Series,
    /// Its derivative \[rad/s\].
    pub(crate) r: Series,
    /// The velocities to north and east, where there are positions \[m/s\].
    pub(crate) over_ground: Option<[Series; 2]>,
}

impl Derivatives {
    /// `None` without a heading.
    pub(crate) fn of(channels: &Channels, window_s: f64) -> Option<Self> {
        let smoothed = |name: &str| channels.get(name).map(|series| series.smoothed(window_s));
        let slope = |name: &str| smoothed(name).map(|(_, slope)| slope);
        let (psi, r) = smoothed("psi")?;
        let over_ground = slope("x").zip(slope("y")).map(|(north, east)| [north, east]);
        Some(Self { psi, r, over_ground })
    }

    /// Compares measured surge, sway and yaw rate with these. `None` where either is unknown or they never overlap.
    pub(crate) fn compared(&self, channels: &Channels) -> [Option<MotionSummary>; 3] {
        let Self { psi, r, over_ground } = self;
        [("y_u", State::U), ("y_v", State::V), ("y_r", State::R)].map(|(name, state)| {
            let measured = channels.get(name)?;
            let rate_hz = measured.rate_hz()?.min(COMPARED_HZ);
            let times = times_of(measured, rate_hz);
            let derivative = match (state, over_ground) {
                (State::R, _) => times.made(r.at(times.iter())),
                (_, Some([north, east])) => {
                    let rates = north.at(times.iter()).zip(east.at(times.iter()));
                    let body = |((n, e), psi)| body_velocity([n, e], psi)[state as usize];
                    times.made(rates.zip(psi.at(times.iter())).map(body))
                }
                (_, None) => return None,
            };
            compare(state, &times.made(measured.at(times.iter())), &derivative, rate_hz)
        })
    }
}

/// Compares measured surge, sway and yaw rate with the derivatives of position and heading, taken from
/// parabolas over `window_s`. `None` where either is not measured or they never overlap.
pub fn consistency(channels: &Channels, window_s: f64) -> [Option<MotionSummary>; 3] {
    Derivatives::of(channels, window_s).map_or([None; 3], |derivatives| derivatives.compared(channels))
}

/// The moments at which a channel is compared with others.
pub(crate) fn at_most(series: &Series) -> Option<Samples> {
    Some(times_of(series, series.rate_hz()?.min(COMPARED_HZ)))
}

/// Times at `rate_hz` in the sections without gaps, and one halfway through each gap, where nothing is known.
fn times_of(series: &Series, rate_hz: f64) -> Samples {
    let (mut times, mut before) = (series.t.none(), None);
    for section in series.sections() {
        let ends = [section.start, section.end - 1].map(|end| series.t.range(end..end + 1).next());
        let [Some(first), Some(last)] = ends else { continue };
        if let Some(before) = before {
            times.push(0.5 * (before + first));
        }
        Grid::new(first, last, rate_hz).times().for_each(|time| times.push(time));
        before = Some(last);
    }
    times
}

fn compare(state: State, measured: &Samples, derivative: &Samples, rate_hz: f64) -> Option<MotionSummary> {
    let differences = || measured.iter().zip(derivative.iter()).map(|(m, d)| m - d);
    let differences = measured.made(differences().filter(|difference| difference.is_finite()));
    if differences.is_empty() {
        return None;
    }
    let mean = |f: &dyn Fn(f64) -> f64| differences.iter().map(f).sum::<f64>() / differences.len() as f64;
    let (rms, bias) = (mean(&|d| d * d).sqrt(), mean(&|d| d));
    let longest = longest(measured, derivative);
    let [measured, derivative] = [measured, derivative].map(|of| of.made(of.range(longest.clone())));
    Some(MotionSummary {
        state,
        rms,
        robust_std: FROM_MEDIAN * robust_deviation(&differences),
        bias,
        lag_s: lag(&measured, &derivative, rate_hz, LONGEST_LAG_S),
        gain: gain(&measured, &derivative),
    })
}

/// The longest run of samples at which both are known, the last one of several.
fn longest(measured: &Samples, derivative: &Samples) -> Range<usize> {
    let known = measured.iter().zip(derivative.iter()).map(|(m, d)| m.is_finite() && d.is_finite());
    let (mut longest, mut start) = (0..0, 0);
    for (i, _) in known.chain([false]).enumerate().filter(|(_, known)| !known) {
        if i - start >= longest.len() {
            longest = start..i;
        }
        start = i + 1;
    }
    longest
}

/// See [`MotionSummary::gain`].
fn gain(measured: &Samples, derivative: &Samples) -> Option<f64> {
    let n = derivative.len() as f64;
    let mean = derivative.iter().sum::<f64>() / n;
    let squares: f64 = derivative.iter().map(|d| (d - mean) * (d - mean)).sum();
    let products: f64 = measured.iter().zip(derivative.iter()).map(|(m, d)| m * (d - mean)).sum();
    let correlation = correlations(measured, derivative, 0)[0];
    (correlation.abs() > SAME_MOTION).then(|| products / squares)
}

/// By how much `measured` comes after `reference` \[s\]; both at `rate_hz`, equally long. The shift within
/// ±`longest_s` (and a quarter of the length) with the highest correlation coefficient over the overlap,
/// refined by the parabola through it and its neighbours. `None` where the coefficient stays below 0.5 or is
/// highest at the longest shift: then the motion does not determine the lag.
pub fn lag(measured: &Samples, reference: &Samples, rate_hz: f64, longest_s: f64) -> Option<f64> {
    let longest = ((longest_s * rate_hz).round() as usize).min(measured.len() / 4);
    let coefficients = correlations(measured, reference, longest);
    let (peak, highest) = coefficients.iter().enumerate().max_by(|a, b| a.1.total_cmp(b.1))?;
    if *highest < 0.5 || peak == 0 || peak + 1 == coefficients.len() {
        return None;
    }
    let [before, after] = [coefficients[peak - 1], coefficients[peak + 1]];
    let bend = before - 2.0 * highest + after;
    let refined = if bend < 0.0 { 0.5 * (before - after) / bend } else { 0.0 };
    Some((peak as f64 - longest as f64 + refined) / rate_hz)
}

/// Sums over the overlap at one shift.
#[derive(Clone)]
struct Overlap {
    /// Where it begins in either series.
    starts: [usize; 2],
    /// How long it is.
    len: usize,
    means: [f64; 2],
    /// Of squares of deviations from the means, and of their products.
    squares: [f64; 2],
    products: f64,
}

/// Pearson's coefficients of `a` with `b` at shifts from −`longest` to `longest`; 0 where either is constant.
pub(crate) fn correlations(a: &Samples, b: &Samples, longest: usize) -> Vec<f64> {
    let overlap = |shift: usize| Overlap {
        starts: [shift.saturating_sub(longest), longest.saturating_sub(shift)],
        len: a.len() - shift.abs_diff(longest),
        // The sum of an empty iterator.
        means: [-0.0; 2],
        squares: [0.0; 2],
        products: 0.0,
    };
    let mut overlaps: Vec<Overlap> = (0..=2 * longest).map(overlap).collect();
    each_overlap(&mut overlaps, [a, b], |overlap, [a, b]| {
        overlap.means[0] = a.iter().fold(overlap.means[0], |sum, a| sum + a);
        overlap.means[1] = b.iter().fold(overlap.means[1], |sum, b| sum + b);
    });
    overlaps.iter_mut().for_each(|overlap| overlap.means = overlap.means.map(|sum| sum / overlap.len as f64));
    each_overlap(&mut overlaps, [a, b], |overlap, [a, b]| {
        for (a, b) in a.iter().zip(b) {
            let (a, b) = (a - overlap.means[0], b - overlap.means[1]);
            overlap.squares[0] += a * a;
            overlap.squares[1] += b * b;
            overlap.products += a * b;
        }
    });
    let coefficient = |overlap: Overlap| {
        let norm = (overlap.squares[0] * overlap.squares[1]).sqrt();
        if norm > 0.0 { overlap.products / norm } else { 0.0 }
    };
    overlaps.into_iter().map(coefficient).collect()
}

/// Adds its values to every overlap block by block: a long channel is never in memory as a whole.
fn each_overlap(overlaps: &mut [Overlap], both: [&Samples; 2], add: impl Fn(&mut Overlap, [&[f64]; 2])) {
    const AT_A_TIME: usize = 1 << 14;
    let mut views = both.map(View::new);
    for part in (0..both[0].len()).step_by(AT_A_TIME) {
        for overlap in overlaps.iter_mut().filter(|overlap| part < overlap.len) {
            let end = (part + AT_A_TIME).min(overlap.len);
            let [a, b] = &mut views;
            let [first, second] = overlap.starts;
            add(overlap, [a.slice(first + part..first + end), b.slice(second + part..second + end)]);
        }
    }
}

// Whether samples come about as often as requested: where they are off by far, times are in another unit.

/// No setup resamples to a rate that is so many times higher or lower than the logged one.
const FAR: f64 = 900.0;

/// Nor so many times higher in a recording of a few seconds.
const OFTEN: f64 = 90.0;
const SHORT_S: f64 = 5.0;

/// A recording of fewer samples is a short one.
const FEW: f64 = 100.0;

/// Refuses channels whose steps are a thousandth, or thousands, of the requested step.
pub(crate) fn check_pace(
    setup: &Setup,
    channels: &Channels,
    summaries: &[ChannelSummary],
) -> Result<(), Invalid> {
    let common = setup.conventions.rate_hz;
    // Some channels, such as depth, may be logged very slowly.
    let all_slow =
        summaries.iter().filter_map(|channel| channel.rate_hz).all(|rate| rate / common <= 1.0 / FAR);
    for spec in setup.channels() {
        let rate =
            summaries.iter().find(|channel| channel.name == spec.channel).and_then(|channel| channel.rate_hz);
        let times = channels.get(&spec.channel).map(|series| &series.t);
        let (Some(rate), Some([first, last])) = (rate, times.and_then(|t| Some([t.first()?, t.last()?])))
        else {
            continue;
        };
        let (pace, duration_s) = (rate / common, last - first);
        let too_fast = pace >= FAR && duration_s * common < FEW || pace >= OFTEN && duration_s < SHORT_S;
        if !too_fast && !all_slow {
            continue;
        }
        let unit = if too_fast { "seconds, or milliseconds" } else { "milliseconds, or finer" };
        return Err(Invalid::new(
            format!("times of channel `{}`", spec.channel),
            format!("{:.3e} s from row to row, {duration_s:.3} s in all", 1.0 / rate),
            format!("about {} s, as `sample_rate_hz` says", 1.0 / common),
            format!("correct the time's `unit`: it may count {unit}; or else `sample_rate_hz`"),
        ));
    }
    Ok(())
}
