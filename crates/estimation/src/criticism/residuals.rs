use std::f64::consts::TAU;

use libm::cos;
use numerics::statistics::median;
use numerics::statistics::{chi_square_tail, log_chi_square_tail, normal_tails};
use numerics::{quadratic_of_inverse, times};
use ship::engine::RunView;
use ship::model::Model;

use super::problems::{Problems, Series, Subject, TestedEstimate};
use super::verdict::{Apart, Feedback};
use crate::predictor::{Linear, scaled_inverse};

/// Largest probability, and least correlation, for an input's response to be reported.
const UNLIKELY: f64 = 1e-3;
const WEAK: f64 = 0.1;

/// Innovations of an input are clipped at this many times their median: few steps of a course must not dominate.
const MOST: f64 = 3.0;

/// The input whose innovations go most with the white errors, if any does: then something answers within the sample. An
/// autopilot with a sensor of its own responds to the true motion alone, which is no noise.
pub(super) fn feedback(model: &Model, runs: &[RunView], series: &Series) -> Option<Feedback> {
    let width = model.exogenous();
    let tests = 3 * model.inputs;
    let mut most: Option<Feedback> = None;
    for input in 0..model.inputs {
        let value = |run: usize, k: usize| runs[run].exogenous[k * width + input];
        let Some(innovations) = innovations(series, value, runs) else { continue };
        for (state, name) in ["u", "v", "r"].into_iter().enumerate() {
            let (mut both, mut squares, mut errors, mut n) = (0.0, 0.0, 0.0, 0.0);
            for ((_, white), innovations) in series.iter().zip(&innovations) {
                // White errors begin at sample 1, innovations at sample 2.
                for (a, b) in innovations.iter().zip(&white[state][1..]) {
                    both += a * b;
                    squares += a * a;
                    errors += b * b;
                    n += 1.0;
                }
            }
            let correlation = both / (squares * errors).sqrt();
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
    most.filter(|feedback| feedback.p_value < UNLIKELY && feedback.correlation.abs() > WEAK)
}

/// Innovations of an input per run, from sample 2 on: what its last two values do not predict; `None` without any.
fn innovations(series: &Series, at: impl Fn(usize, usize) -> f64, runs: &[RunView]) -> Option<Vec<Vec<f64>>> {
    let row = |run: usize, k: usize| [at(run, k - 1), at(run, k - 2), 1.0];
    let (mut normal, mut gradient) = ([0.0; 9], [0.0; 3]);
    let mut squares = 0.0;
    for (run, _) in series {
        for k in 2..runs[*run].samples() {
            let (row, y) = (row(*run, k), at(*run, k));
            numerics::add_outer(&mut normal, &row, &row);
            gradient.iter_mut().zip(row).for_each(|(sum, x)| *sum += x * y);
            squares += y * y;
        }
    }
    let mut foretold = gradient;
    // Inputs that hardly vary are predicted well enough by one of the two.
    (0..3).for_each(|i| normal[4 * i] *= 1.0 + 1e-9);
    numerics::solve(3, &mut normal, &mut foretold)?;
    let of = |run: usize, k: usize| at(run, k) - numerics::dot(&foretold, &row(run, k));
    let all: Vec<Vec<f64>> =
        series.iter().map(|(run, _)| (2..runs[*run].samples()).map(|k| of(*run, k)).collect()).collect();
    let left: f64 = all.iter().flatten().map(|x| x * x).sum();
    let typical = median(all.iter().flatten().map(|x| x.abs()).collect())?;
    let held = |x: f64| x.clamp(-MOST * typical, MOST * typical);
    let all = all.into_iter().map(|errors| errors.into_iter().map(held).collect()).collect();
    (left > 1e-12 * squares && typical > 0.0).then_some(all)
}

// Errors that oscillate, as those of a ship that waves move: a narrow peak of their spectrum.

const LAGS: usize = 3;
const TRIED: f64 = 8.0;
/// How far a peak is above the spectrum an octave below and above.
const NARROW: f64 = 3.0;
/// White errors have a peak this rarely.
const CHANCE: f64 = 1e-3;
/// Shortest period \[samples\], longest \[s\]: waves are no longer.
const PERIODS: [f64; 2] = [4.0, 20.0];

/// The period \[s\] of waves in the whitened errors of runs, if they have one and no input oscillates alike.
pub(super) fn waves(subject: &Subject, errors: &Series) -> Option<f64> {
    let of = |d: usize| -> Vec<Vec<f64>> { errors.iter().map(|(_, white)| white[d].clone()).collect() };
    let peaks = (0..3).filter_map(|d| oscillation(&of(d), subject.rate_hz));
    let (period, _) = peaks.max_by(|a, b| a.1.total_cmp(&b.1))?;
    let inputs = subject.model.exogenous();
    let steered = (0..inputs).any(|i| {
        let of = |(run, _): &(usize, _)| {
            let input = subject.runs[*run].exogenous.iter().skip(i).step_by(inputs);
            centred(input.copied().collect())
        };
        let steered: Vec<Vec<f64>> = errors.iter().map(of).collect();
        let period = period * subject.rate_hz;
        peak(&covariances(&steered, period), period).is_some()
    });
    (!steered).then_some(period)
}

/// The period \[s\] at which `errors`, recording by recording, have their highest narrow peak, and its height over that of
/// white errors.
pub fn oscillation(errors: &[Vec<f64>], rate_hz: f64) -> Option<(f64, f64)> {
    let errors = &without_trend(errors);
    let (samples, longest) =
        (errors.iter().map(Vec::len).sum::<usize>() as f64, errors.iter().map(Vec::len).max()?);
    let most = (PERIODS[1] * rate_hz).min(longest as f64 / 4.0);
    let steps = (most / PERIODS[0]).log2() * TRIED;
    let tried = (0..=steps.max(-1.0) as i64).map(|i| PERIODS[0] * (i as f64 / TRIED).exp2());
    let covariances = covariances(errors, most);
    let peaks = tried.filter_map(|period| Some((period, peak(&covariances, period)?)));
    let (period, height) = peaks.max_by(|a, b| a.1.total_cmp(&b.1))?;
    let freedom = 8.0 * samples / (3.0 * LAGS as f64 * period);
    (chi_square_tail(freedom * height, freedom) < CHANCE / steps.max(1.0))
        .then_some((period / rate_hz, height))
}

/// The spectrum at `period` \[samples\] over its mean, if it is narrow.
fn peak(covariances: &[f64], period: f64) -> Option<f64> {
    let [low, here, high] = [2.0, 1.0, 0.5].map(|factor| spectrum(covariances, factor * period));
    (here > NARROW * low.max(high)).then_some(here)
}

/// By the window of Hann over the autocovariances.
fn spectrum(covariances: &[f64], period: f64) -> f64 {
    let last = LAGS as f64 * period;
    let term = |lag: usize| {
        let window = 0.5 + 0.5 * cos(TAU * 0.5 * lag as f64 / last);
        2.0 * window * cos(TAU * lag as f64 / period) * covariances[lag]
    };
    let power = covariances[0];
    if power > 0.0 { 1.0 + (1..last as usize).map(term).sum::<f64>() / power } else { 0.0 }
}

fn without_trend(errors: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let [power, next] = [0, 1].map(|lag| covariance(errors, lag));
    let keep = if power > 0.0 { next / power } else { 0.0 };
    errors.iter().map(|e| e.windows(2).map(|pair| pair[1] - keep * pair[0]).collect()).collect()
}

/// By lag, as many as the spectra about periods of up to `longest` samples take.
fn covariances(errors: &[Vec<f64>], longest: f64) -> Vec<f64> {
    (0..=(2.0 * LAGS as f64 * longest) as usize).map(|lag| covariance(errors, lag)).collect()
}

/// Σ e(k) e(k − lag) over all recordings.
fn covariance(errors: &[Vec<f64>], lag: usize) -> f64 {
    let one = |e: &Vec<f64>| -> f64 { e.iter().skip(lag).zip(e).map(|(a, b)| a * b).sum() };
    errors.iter().map(one).sum()
}

fn centred(mut all: Vec<f64>) -> Vec<f64> {
    let mean = all.iter().sum::<f64>() / all.len().max(1) as f64;
    all.iter_mut().for_each(|x| *x -= mean);
    all
}

/// A recording contradicts the others if chance explains any of them with a smaller probability than this.
const LEVEL: f64 = 1e-4;
/// A parameter depends on the others if less than this share of its signal is independent of theirs.
const LEFT: f64 = 1e-6;

/// Recordings that contradict the others, the farthest first, until the rest agree; at most half of them.
pub(super) fn apart(problems: &Problems, state: &TestedEstimate) -> Vec<Apart> {
    let mut left = recordings(problems, state);
    let mut out = Vec::new();
    let most = left.len() / 2;
    while left.len() > 2 && out.len() < most {
        let count = left.len() as f64;
        let Some((farthest, log_p)) = farthest(&left) else { break };
        let p_value = (count * libm::exp(log_p)).min(1.0);
        if p_value >= LEVEL {
            break;
        }
        out.push(Apart { recording: left.remove(farthest).0, p_value });
    }
    out
}

fn recordings(problems: &Problems, state: &TestedEstimate) -> Vec<(String, Linear)> {
    let mut all: Vec<(String, Linear)> = Vec::new();
    for (run, linear) in problems.by_run(state) {
        let name = problems.subject.names[run];
        match all.iter_mut().find(|(subject, _)| subject == name) {
            Some((_, sums)) => sums.add(&linear),
            None => all.push((name.to_owned(), linear)),
        }
    }
    all.retain(|(_, sums)| sums.finite());
    all
}

/// The recording that is least probable given the others, with the logarithm of its probability.
fn farthest(all: &[(String, Linear)]) -> Option<(usize, f64)> {
    let mut total = all.first()?.1.clone();
    all[1..].iter().for_each(|(_, sums)| total.add(sums));
    let (normal, gradient) = total.weighted([1.0; 3]);
    let p = gradient.len();
    let inverse = scaled_inverse(&normal, p).ok()?;
    let change = times(&inverse, &gradient);
    let explained: f64 = change.iter().zip(&gradient).map(|(a, b)| a * b).sum();
    let freedom = (3.0 * total.samples - p as f64).max(1.0);
    let variance = (total.squares.iter().sum::<f64>() - explained) / freedom;
    let tested = all.iter().enumerate().filter_map(|(i, (_, sums))| {
        let (information, scores) = sums.weighted([1.0; 3]);
        // Scores of the recording at the estimate from all recordings, and their covariance over the variance.
        let scores: Vec<f64> =
            scores.iter().zip(times(&information, &change)).map(|(s, explained)| s - explained).collect();
        let rows: Vec<f64> = information.chunks_exact(p).flat_map(|row| times(&inverse, row)).collect();
        let covariance: Vec<f64> = (0..p * p)
            .map(|k| {
                let (i, j) = (k / p, k % p);
                information[k] - numerics::dot(&rows[i * p..(i + 1) * p], &information[j * p..(j + 1) * p])
            })
            .collect();
        let whole: Vec<f64> = (0..p).map(|i| information[i * p + i]).collect();
        let (statistic, rank) = quadratic_of_inverse(covariance, scores, &whole, LEFT);
        (rank > 0).then(|| (i, log_chi_square_tail(statistic / variance, rank)))
    });
    tested.min_by(|a, b| a.1.total_cmp(&b.1))
}
