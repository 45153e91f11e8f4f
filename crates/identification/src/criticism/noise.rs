use vessel::lanes::SideBySide;
use vessel::{Lane, Model};

use crate::sensitivity::{Flow, Gain, Levels, Recordings, filter, with_states};

/// Steps by which logarithms of levels are changed, one after the other; the last alone for levels that were found before.
const STEPS: [f64; 4] = [1.2, 0.5, 0.2, 0.08];
/// Most rounds at one step.
const ROUNDS: usize = 6;
/// Samples that are enough to know the noise.
const ENOUGH: usize = 12_000;
/// Times over which a drifting current is first thought to change \[s\].
const TIMES: [f64; 2] = [8.0, 60.0];

/// What is looked for: its kind, and logarithms of its levels.
#[derive(Clone, Debug)]
pub(super) struct Guess {
    drifts: bool,
    /// Measurement u, v, r; current; time of a drift \[s\].
    logs: Vec<f64>,
}

impl Guess {
    pub fn levels(&self, rate_hz: f64) -> Levels {
        let level = |i: usize| libm::exp(self.logs[i]);
        let current = match self.drifts {
            false => Flow::White { std: level(3) },
            true => Flow::Markov {
                std: level(3),
                factor: libm::exp(-1.0 / (rate_hz * level(4))),
                turning: 1.0 / rate_hz,
            },
        };
        Levels { measurement: [level(0), level(1), level(2)], current, force: None }
    }
}

/// The noise and the current, white or drifting, that make the first of `runs` most likely under `model` with `parameters`.
/// The search begins at what was found `before`, or where `errors` say, the standard deviations of the errors of free
/// simulations.
pub(super) fn noise_of(
    model: &Model,
    runs: &[SideBySide],
    parameters: &[f64],
    errors: [f64; 3],
    rate_hz: f64,
    known_start: bool,
    before: Option<&Guess>,
) -> Option<Guess> {
    let mut samples = 0;
    let few = |run: &&SideBySide| {
        let enough = samples >= ENOUGH;
        samples += run.samples[..run.runs].iter().sum::<usize>();
        !enough
    };
    let runs: Vec<&SideBySide> = runs.iter().take_while(few).collect();
    let worth = |guess: &Guess| likelihood(model, &runs, parameters, &guess.levels(rate_hz), known_start);
    if let Some(before) = before {
        return Some(climb(before.clone(), &STEPS[STEPS.len() - 1..], &worth).0);
    }
    let noise = errors.map(|error| libm::log(error.max(1e-9)));
    let current = libm::log(libm::hypot(errors[0], errors[1]).max(1e-9));
    let white = Guess { drifts: false, logs: [&noise[..], &[current - 3.0]].concat() };
    let drift = |time: &f64| {
        let quiet = noise.map(|log| log - 1.0);
        Guess { drifts: true, logs: [&quiet[..], &[current, libm::log(*time)]].concat() }
    };
    let starts = std::iter::once(white).chain(TIMES.iter().map(drift));
    let found = starts.map(|start| climb(start, &STEPS, &worth));
    found.max_by(|a, b| a.1.total_cmp(&b.1)).map(|(guess, _)| guess)
}

/// Changes one logarithm after the other as long as that helps, by smaller and smaller `steps`.
fn climb(mut at: Guess, steps: &[f64], worth: &impl Fn(&Guess) -> f64) -> (Guess, f64) {
    let mut best = worth(&at);
    for step in steps.iter().copied() {
        for _ in 0..ROUNDS {
            let before = best;
            for i in 0..at.logs.len() {
                for change in [step, -step] {
                    let mut trial = at.clone();
                    trial.logs[i] += change;
                    let own = worth(&trial);
                    if own > best {
                        (at, best) = (trial, own);
                        break;
                    }
                }
            }
            if best - before < 1e-2 {
                break;
            }
        }
    }
    (at, best)
}

/// Twice the log-likelihood of all runs, but for a constant; −∞ where the filter's numbers end.
fn likelihood(
    model: &Model,
    runs: &[&SideBySide],
    parameters: &[f64],
    levels: &Levels,
    known_start: bool,
) -> f64 {
    let each =
        runs.iter().map(|run| with_states!(levels, worth(model, run, parameters, levels, known_start)));
    let sum: f64 = each.sum();
    if sum.is_finite() { sum } else { f64::NEG_INFINITY }
}

fn worth<const N: usize>(
    model: &Model,
    run: &SideBySide,
    parameters: &[f64],
    levels: &Levels,
    known_start: bool,
) -> f64 {
    let recordings = Recordings::of(model, run);
    let unknowns = unknowns(parameters);
    let (gains, innovations) = filter::<N>(&recordings, &unknowns, levels, known_start);
    let mut sum = 0.0;
    for (k, (gain, error)) in gains.iter().zip(innovations.as_chunks().0).enumerate() {
        if k == 0 {
            continue;
        }
        let (white, scales) = (gain.white(error), gain.scales());
        for lane in (0..run.runs).filter(|lane| k <= run.samples[*lane]) {
            let det: f64 = scales.iter().map(|s| s[lane]).product();
            sum += 2.0 * libm::log(det) - white.iter().map(|w| w[lane] * w[lane]).sum::<f64>();
        }
    }
    sum
}

/// Parameters of every run, and initial states as given.
pub(super) fn unknowns(parameters: &[f64]) -> Vec<Lane> {
    parameters.iter().copied().chain([0.0; 3]).map(Lane::splat).collect()
}

/// Innovations made white at each sample after the first, by lane: u, v, r.
pub(super) fn white<const N: usize>(
    run: &SideBySide,
    gains: &[Gain<Lane, N>],
    innovations: &[Lane],
) -> Vec<[Vec<f64>; 3]> {
    let all: Vec<[Lane; 3]> =
        gains.iter().zip(innovations.as_chunks().0).map(|(gain, error)| gain.white(error)).collect();
    let own = |lane: usize| {
        let rows = &all[1..=run.samples[lane].min(all.len() - 1)];
        [0, 1, 2].map(|d: usize| rows.iter().map(|white| white[d][lane]).collect())
    };
    (0..run.runs).map(own).collect()
}
