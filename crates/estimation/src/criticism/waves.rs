//! Errors that oscillate, as those of a ship that waves move: a narrow peak of their spectrum.

use std::f64::consts::TAU;

use libm::cos;
use numerics::distributions::chi_square_tail;

use super::problems::{Series, Subject};

/// Lags of the windows of spectra, in periods.
const LAGS: usize = 3;
/// Periods that are tried per octave.
const TRIED: f64 = 8.0;
/// How far a peak is above the spectrum an octave below and above.
const NARROW: f64 = 3.0;
/// White errors have a peak this rarely.
const CHANCE: f64 = 1e-3;
/// Shortest period \[samples\], longest \[s\]: waves are no longer.
const PERIODS: [f64; 2] = [4.0, 20.0];

/// The period \[s\] of waves in the whitened errors of runs, if they have one and no input oscillates alike.
pub(super) fn waves(subject: &Subject, errors: &Series) -> Option<f64> {
    let of = |d: usize| -> Vec<Vec<f64>> { errors.iter().map(|(_, own)| own[d].clone()).collect() };
    let found = (0..3).filter_map(|d| oscillation(&of(d), subject.rate_hz));
    let (period, _) = found.max_by(|a, b| a.1.total_cmp(&b.1))?;
    let inputs = subject.model.exogenous();
    let steered = (0..inputs).any(|i| {
        let of = |(run, _): &(usize, _)| {
            let own = subject.runs[*run].exogenous.iter().skip(i).step_by(inputs);
            centred(own.copied().collect())
        };
        let own: Vec<Vec<f64>> = errors.iter().map(of).collect();
        let period = period * subject.rate_hz;
        peak(&covariances(&own, period), period).is_some()
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
    let found = tried.filter_map(|period| Some((period, peak(&covariances, period)?)));
    let (period, height) = found.max_by(|a, b| a.1.total_cmp(&b.1))?;
    let freedom = 8.0 * samples / (3.0 * LAGS as f64 * period);
    (chi_square_tail(freedom * height, freedom) < CHANCE / steps.max(1.0))
        .then_some((period / rate_hz, height))
}

/// The spectrum at `period` \[samples\] over its mean, if it is narrow.
fn peak(covariances: &[f64], period: f64) -> Option<f64> {
    let [low, own, high] = [2.0, 1.0, 0.5].map(|factor| spectrum(covariances, factor * period));
    (own > NARROW * low.max(high)).then_some(own)
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

/// What is left after the autocorrelation of neighbours.
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
