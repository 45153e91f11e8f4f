//! Recordings that contradict the others: crude models of each by all others, which outliers do not move.

use numerics::dot;
use numerics::statistics::median;

use super::table::{Sums, scatter};
use crate::RecordedRun;
use crate::record::RecordingSummary;

/// Samples over which changes are compared, of which the one that steering explains most by is taken.
const WINDOWS: [usize; 4] = [2, 4, 8, 16];
/// Fewer recordings tell nothing of each other.
const LEAST: usize = 4;
/// Most samples and inputs of a recording that are looked at.
const SAMPLES: usize = 20_000;
const INPUTS: usize = 6;
/// Fewer windows of a recording tell nothing.
const ROWS: usize = 8;
/// Rounds of robust weights, and the residuals from which on weights fall, in robust deviations.
const ROUNDS: usize = 5;
const HUBER: f64 = 1.5;
/// Robust deviations of a median deviation.
const TO_STD: f64 = 1.4826;
/// A gain below this is none of any ship; where more than this share of recordings has one, nothing is judged.
const ABSURD: f64 = -2.0;
const FAILS: f64 = 0.1;
/// Steering is reversed with a gain below this, the errors taken three times reaching no further than that.
const REVERSED: f64 = -0.15;
const AT_MOST: f64 = 0.25;
const ERRORS: f64 = 3.0;
/// Or it is this many robust deviations below the others.
const LOW: f64 = 4.0;
/// The share of the usual excitation below which nothing is judged.
const EXCITED: f64 = 0.1;
/// Surge contradicts where the logarithm of its error is this many robust deviations above the others', or more than a share of the
/// samples this many.
const FAR: f64 = 3.0;
const BEYOND: (f64, f64) = (3.0, 0.3);
/// The least spread of gains and of logarithms of errors that others are taken to have.
const SPREAD: f64 = 0.1;
/// Steering that explains less than this of changes of the yaw rate tells nothing.
const STEERS: f64 = 0.1;

/// A recording as it was sampled, run by run.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SampledRecording {
    /// Of each run surge, sway \[m/s\] and yaw rate \[rad/s\], then its inputs.
    pub runs: Vec<Vec<Vec<f64>>>,
}

impl SampledRecording {
    /// The first samples of `runs` with their first inputs, of `inputs`.
    pub fn of(runs: &[RecordedRun], inputs: usize) -> Self {
        let mut left = SAMPLES;
        let of_run = |run: &RecordedRun| {
            let samples = run.samples().min(left);
            left -= samples;
            let motion = (0..3).map(|d| run.measured(d).take(samples + 1).collect());
            motion.chain((0..inputs.min(INPUTS)).map(|i| run.exogenous(i).take(samples).collect())).collect()
        };
        Self { runs: runs.iter().map(of_run).collect() }
    }
}

/// What others say of a recording.
#[derive(Clone, Debug, PartialEq)]
pub enum Agreement {
    /// It is as the others, as far as these tell.
    Alike,
    /// It is not, in words.
    Against(String),
    /// It cannot be judged, in words.
    Unjudged(&'static str),
}

impl Agreement {
    /// Notes it in the summary of its `recording`.
    pub fn noted(self, recording: &mut RecordingSummary) {
        match self {
            Self::Alike => {}
            Self::Against(why) => recording.contradicts = Some(why),
            Self::Unjudged(why) => recording.unjudged = Some(why.to_owned()),
        }
    }
}

/// Judges each of `recordings` by models of the others; `dt` is the time between samples \[s\].
pub fn judged(recordings: &[SampledRecording], dt: f64) -> Vec<Agreement> {
    if recordings.len() < LEAST {
        return vec![Agreement::Alike; recordings.len()];
    }
    let steered = steered(recordings, dt);
    let surged = surged(recordings, dt);
    let both = steered.into_iter().zip(surged);
    both.map(|(steered, surged)| match (steered, surged) {
        (Agreement::Against(one), Agreement::Against(other)) => Agreement::Against(format!("{one}; {other}")),
        (Agreement::Against(why), _) | (_, Agreement::Against(why)) => Agreement::Against(why),
        (steered, _) => steered,
    })
    .collect()
}

/// Rows of regressors and their targets.
type Rows = Vec<(Vec<f64>, f64)>;

/// What may steer: an input, or the difference of two.
fn signals(inputs: usize) -> Vec<(usize, Option<usize>)> {
    let pairs = (0..inputs).flat_map(|a| (a + 1..inputs).map(move |b| (a, Some(b))));
    (0..inputs).map(|a| (a, None)).chain(pairs).collect()
}

/// Regressors that have no steering.
const BASE: usize = 3;

fn steering_rows(
    recording: &SampledRecording,
    dt: f64,
    window: usize,
    (a, b): (usize, Option<usize>),
) -> Rows {
    let of_run = |run: &Vec<Vec<f64>>| {
        let ([u, _, r, ..], inputs) = (&run[..], &run[3..]) else { return Vec::new() };
        let s = |k: usize| inputs[a][k] - b.map_or(0.0, |b| inputs[b][k]);
        let last = inputs[a].len().min(r.len() - 1);
        let row = |from: usize| {
            let mut all = vec![0.0; BASE + 4];
            for k in from..from + window {
                let (u, r, s) = (u[k], r[k], s(k));
                let now = [r, r * r.abs(), u * r, s, s * u.abs(), s * u * u, s * s.abs()];
                all.iter_mut().zip(now).for_each(|(sum, value)| *sum += dt * value);
            }
            (all, r[from + window] - r[from])
        };
        (0..(last + 1).saturating_sub(window)).step_by(window).map(row).collect()
    };
    recording.runs.iter().flat_map(of_run).collect()
}

fn sums(rows: &[&(Vec<f64>, f64)], weights: &[f64]) -> Sums {
    let n = rows.first().map_or(0, |(row, _)| row.len());
    let columns: Vec<Vec<f64>> =
        (0..n).map(|i| rows.iter().zip(weights).map(|((row, _), w)| w.sqrt() * row[i]).collect()).collect();
    let target: Vec<f64> = rows.iter().zip(weights).map(|((_, y), w)| w.sqrt() * y).collect();
    Sums::of(&columns.iter().map(Vec::as_slice).collect::<Vec<_>>(), &target)
}

/// Coefficients that outliers hardly move, and the robust deviation of the residuals.
fn robust(rows: &[&(Vec<f64>, f64)]) -> Option<(Vec<f64>, f64)> {
    let mut weights = vec![1.0; rows.len()];
    let mut last_fit = None;
    for _ in 0..ROUNDS {
        let solution = sums(rows, &weights).solution()?;
        let left: Vec<f64> = rows.iter().map(|(row, y)| (y - dot(&solution, row)).abs()).collect();
        let deviation = TO_STD * median(left.clone())?;
        let limit = (HUBER * deviation).max(f64::MIN_POSITIVE);
        weights = left.iter().map(|left| (limit / left).min(1.0)).collect();
        last_fit = Some((solution, deviation));
    }
    last_fit
}

fn steered(recordings: &[SampledRecording], dt: f64) -> Vec<Agreement> {
    let none = || vec![Agreement::Alike; recordings.len()];
    let inputs = recordings.iter().flat_map(|entry| &entry.runs).map(|run| run.len() - 3).min().unwrap_or(0);
    // What steers, and over which time: by what each recording says alone, so that none of them spoils it.
    let mut best: Option<(f64, Vec<Rows>)> = None;
    for (signal, window) in signals(inputs).into_iter().flat_map(|s| WINDOWS.map(|window| (s, window))) {
        let rows: Vec<Rows> =
            recordings.iter().map(|entry| steering_rows(entry, dt, window, signal)).collect();
        let alone: Vec<f64> = rows.iter().filter_map(explained_alone).collect();
        let gain = median(alone.clone()).filter(|_| alone.len() >= LEAST).unwrap_or(0.0);
        if gain > STEERS && best.as_ref().is_none_or(|(known, _)| gain > *known) {
            best = Some((gain, rows));
        }
    }
    let Some((_, rows)) = best else { return none() };
    // Who contradicts most is no longer asked about the others.
    let mut apart: Vec<(usize, f64)> = Vec::new();
    loop {
        let gains: Vec<Option<SteeringGain>> =
            (0..rows.len()).map(|at| SteeringGain::of(&rows, at, &apart)).collect();
        let usual = gains.iter().flatten().map(|entry| entry.excited).collect();
        let Some(usual) = median(usual) else { return none() };
        let excited = |entry: &&SteeringGain| entry.excited >= EXCITED * usual;
        let absurd = gains.iter().flatten().filter(excited).filter(|entry| entry.gain < ABSURD).count();
        if absurd as f64 > FAILS * rows.len() as f64 {
            // Not the recordings differ: the model is too crude for their maneuvers.
            let why = "steering differs too much from maneuver to maneuver";
            return vec![Agreement::Unjudged(why); recordings.len()];
        }
        let of_others = |at: usize| {
            let others = gains
                .iter()
                .enumerate()
                .filter(|(other, _)| *other != at && is_among(&apart, *other).is_none());
            spread(
                others
                    .filter_map(|(_, entry)| entry.as_ref())
                    .filter(excited)
                    .map(|entry| entry.gain)
                    .collect(),
            )
        };
        let against = |at: usize| {
            let entry = gains[at].as_ref().filter(excited)?;
            entry.contradicts(of_others(at)).then(|| (at, entry.gain, (entry.gain - 1.0).abs() / entry.error))
        };
        let known = |at: &usize| is_among(&apart, *at).is_none();
        let next = (0..rows.len()).filter(known).filter_map(against).max_by(|a, b| a.2.total_cmp(&b.2));
        match next.filter(|_| 2 * apart.len() < rows.len()) {
            Some((at, gain, _)) => apart.push((at, gain)),
            None => {
                let judge = |(at, entry): (usize, &Option<SteeringGain>)| match (is_among(&apart, at), entry)
                {
                    (Some(gain), _) => Agreement::Against(format!(
                        "steering turns the ship {gain:.2} times as in the others: reversed, exchanged, or of another ship?"
                    )),
                    (None, None) => Agreement::Unjudged("it is too short"),
                    (None, Some(entry)) if !excited(&entry) => Agreement::Unjudged("it hardly steers"),
                    (None, Some(_)) => Agreement::Alike,
                };
                return gains.iter().enumerate().map(judge).collect();
            }
        }
    }
}

fn is_among(apart: &[(usize, f64)], at: usize) -> Option<f64> {
    apart.iter().find(|(known, _)| *known == at).map(|(_, gain)| *gain)
}

/// The share of what is left of changes of the yaw rate that steering explains in one recording.
fn explained_alone(rows: &Rows) -> Option<f64> {
    let all: Vec<_> = rows.iter().collect();
    let whole = sums(&all, &vec![1.0; all.len()]);
    let every: Vec<usize> = (0..BASE + 4).collect();
    let error = |which: &[usize]| {
        let some = whole.some(which);
        Some(some.residual(&some.solution()?) / (all.len() as f64 - which.len() as f64))
    };
    (all.len() > 2 * every.len()).then(|| Some(1.0 - error(&every)? / error(&every[..BASE])?)).flatten()
}

/// The gain of a recording's steering over that of the others, its error, and how much it steers.
struct SteeringGain {
    gain: f64,
    error: f64,
    excited: f64,
}

impl SteeringGain {
    /// That of the recording at `at`, by all but those that are `apart`.
    fn of(rows: &[Rows], at: usize, apart: &[(usize, f64)]) -> Option<Self> {
        let others = (0..rows.len()).filter(|other| *other != at && is_among(apart, *other).is_none());
        let (model, _) = robust(&others.flat_map(|other| &rows[other]).collect::<Vec<_>>())?;
        let entry = rows[at].iter().map(|(row, y)| {
            (vec![dot(&model[BASE..], &row[BASE..]), 1.0], y - dot(&model[..BASE], &row[..BASE]))
        });
        let entry: Vec<(Vec<f64>, f64)> = entry.collect();
        let entry: Vec<_> = entry.iter().collect();
        // What stays the same is none of the steering's: a drift may be as large.
        let excited = scatter(&entry.iter().map(|(row, _)| row[0]).collect::<Vec<_>>());
        let (solution, deviation) = robust(&entry).filter(|_| entry.len() >= ROWS)?;
        Some(Self {
            gain: solution[0],
            error: deviation / excited.sqrt(),
            excited: (excited / entry.len() as f64).sqrt(),
        })
    }

    /// Whether it is reversed, or far below those of the others.
    fn contradicts(&self, (middle, deviation): (f64, f64)) -> bool {
        let most = self.gain + ERRORS * self.error;
        let is_reversed = self.gain < REVERSED && most < AT_MOST;
        let is_low = self.gain < middle - LOW * deviation && most < middle - deviation;
        self.gain > ABSURD && (is_reversed || is_low)
    }
}

/// Median and robust deviation.
fn spread(values: Vec<f64>) -> (f64, f64) {
    let middle = median(values.clone()).unwrap_or(0.0);
    let off = values.iter().map(|value| (value - middle).abs()).collect();
    (middle, (TO_STD * median(off).unwrap_or(0.0)).max(SPREAD))
}

/// Surge as it runs by itself, from its inputs.
fn surged(recordings: &[SampledRecording], dt: f64) -> Vec<Agreement> {
    let window = 4;
    let step = window as f64 * dt;
    let row = |run: &Vec<Vec<f64>>, k: usize, u: f64| {
        let (r, v) = (run[2][k], run[1][k]);
        let inputs =
            run[3..].iter().flat_map(move |input| [step * input[k], step * input[k] * input[k].abs()]);
        [step, step * u, step * u * u.abs(), step * r * r, step * r * v]
            .into_iter()
            .chain(inputs)
            .collect::<Vec<f64>>()
    };
    let ends = |run: &Vec<Vec<f64>>| {
        let last = run[3..].iter().map(Vec::len).min().unwrap_or(0).min(run[0].len().saturating_sub(1));
        (0..(last + 1).saturating_sub(window)).step_by(window)
    };
    let rows: Vec<Rows> = recordings
        .iter()
        .map(|entry| {
            let of = |run| ends(run).map(move |k| (row(run, k, run[0][k]), run[0][k + window] - run[0][k]));
            entry.runs.iter().flat_map(of).collect()
        })
        .collect();
    // Errors of the free run of each, by a model of the others that are not apart.
    let errors = |at: usize, apart: &[(usize, f64)]| -> Option<Vec<f64>> {
        let others = (0..rows.len()).filter(|other| *other != at && is_among(apart, *other).is_none());
        let (model, _) = robust(&others.flat_map(|other| &rows[other]).collect::<Vec<_>>())?;
        let mut all = Vec::new();
        for run in &recordings[at].runs {
            let mut u = run[0].first().copied().unwrap_or(0.0);
            for k in ends(run) {
                u += dot(&model, &row(run, k, u));
                all.push(u - run[0][k + window]);
            }
        }
        (all.len() >= ROWS && all.iter().all(|error| error.is_finite())).then_some(all)
    };
    let logarithm = |entry: &Vec<f64>| libm::log((dot(entry, entry) / entry.len() as f64).sqrt().max(1e-9));
    // The mean square of what a speed is off its mean.
    let scattered = |at: usize| {
        let speeds: Vec<f64> = recordings[at].runs.iter().flat_map(|run| run[0].iter().copied()).collect();
        scatter(&speeds) / speeds.len().max(1) as f64
    };
    // Who contradicts most is no longer asked about the others.
    let mut apart: Vec<(usize, f64)> = Vec::new();
    loop {
        let known = |at: &usize| is_among(&apart, *at).is_none();
        let errors: Vec<(usize, Vec<f64>)> =
            (0..rows.len()).filter(known).filter_map(|at| Some((at, errors(at, &apart)?))).collect();
        if errors.len() < LEAST {
            break;
        }
        let (middle, deviation) = spread(errors.iter().map(|(_, entry)| logarithm(entry)).collect());
        let all: Vec<f64> = errors.iter().flat_map(|(_, entry)| entry).map(|error| error.abs()).collect();
        let usual = TO_STD * median(all).unwrap_or(0.0);
        let against = |(at, entry): &(usize, Vec<f64>)| {
            let far = (logarithm(entry) - middle) / deviation;
            let beyond = entry.iter().filter(|error| error.abs() > BEYOND.0 * usual).count() as f64;
            let is_far = far > FAR || beyond > BEYOND.1 * entry.len() as f64;
            // A model that is better than no model follows it.
            (is_far && dot(entry, entry) > scattered(*at) * entry.len() as f64).then_some((*at, far))
        };
        match errors.iter().filter_map(against).max_by(|a, b| a.1.total_cmp(&b.1)) {
            Some(most) if 2 * apart.len() < rows.len() => apart.push(most),
            _ => break,
        }
    }
    let why = "its speed does not follow its inputs as in the others: hauled, aground, or of another ship?";
    let judge = |at: usize| match is_among(&apart, at) {
        Some(_) => Agreement::Against(why.to_owned()),
        None => Agreement::Alike,
    };
    (0..rows.len()).map(judge).collect()
}
