//! Search for a model that generalises, from recordings alone.
//!
//! In addition to the base structure, a library of terms is fitted by the errors of free simulations over overlapping
//! windows, with a ridge penalty Λβ² on each scaled parameter β. Λ is chosen by cross-validation over whole
//! recordings, each fold on its own path. The whole algorithm is then scored on recordings that it has not seen.

mod average;
mod compact;
mod judged;
mod library;
mod nested;
mod problem;
mod roles;
mod searched;

use std::cmp::Reverse;

use numerics::statistics::{MeanTrajectory, mean, spread};
use numerics::{LANES, Lane};
use rayon::prelude::*;
use regression::pooled::{Part, PooledRuns};
use ship::engine::{RunView, SideBySide, Weather, simulate};
use ship::model::Model;

use crate::pooled::{FreeRunErrors, Score, deviations};

pub use average::{
    AverageOptions, Averaged, BootstrapOptions, Member, Resampled, ResampledParameter, draw_again, draw_most,
    folds_of_drawn,
};
pub use compact::SizeScore;
pub use judged::{
    Alone, Dealt, FittedShip, Kind, Margin, NestedAverage, NestedRecording, NestedScore, unscored,
};
pub use library::{core, library, with_channels};
pub use nested::Candidate;
pub use roles::Roles;
pub use searched::{SearchError, SearchOptions, Searched, averaged, fits, left_out, search};

/// How recordings are cut.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Cut {
    /// Samples of a window that is fitted.
    pub window: usize,
    /// Samples from the start of one window to that of the next.
    pub every: usize,
    /// Samples of a window that models are scored on; none: whole runs.
    pub scored: Option<usize>,
}

/// The layout of the windows that models are scored on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Laid {
    /// Consecutive from the start of a run, as in other comparisons of models.
    SideBySide,
    /// One begins at every quarter of another, so that a score hardly depends on where the first begins.
    Overlapping,
    /// The same if windows are scored. If whole runs are, windows of the fitted length, or a shorter run: a ridge
    /// chosen over whole runs is too large, because a few long ones dominate.
    Choosing,
}

/// One recording: left out as a whole.
#[derive(Clone, Debug)]
pub struct Recording {
    /// Its name.
    pub name: String,
    /// Its runs, with consecutive ones joined.
    pub whole: Vec<Part>,
    cut: Cut,
}

impl Recording {
    /// All recordings of `runs`.
    pub fn all(runs: &PooledRuns, cut: Cut) -> Vec<Self> {
        runs.windows(None).into_iter().map(|(name, whole)| Self::new(name, whole, cut)).collect()
    }

    /// The recording with this name and the runs `whole`.
    pub fn new(name: String, whole: Vec<Part>, cut: Cut) -> Self {
        Self { name, whole, cut }
    }

    /// Its windows to score, all of one length; whole runs without a length.
    pub(crate) fn scored(&self, laid: Laid) -> impl Iterator<Item = RunView<'_>> + Clone {
        let Cut { window, scored, .. } = self.cut;
        self.whole.iter().flat_map(move |whole| {
            let samples = whole.samples();
            let unscored = if laid == Laid::Choosing { window.min(samples) } else { samples };
            let length = scored.unwrap_or(unscored).max(1);
            let every = if laid == Laid::SideBySide { length } else { length.div_ceil(4) };
            let starts = (0..=samples.saturating_sub(length)).step_by(every);
            starts
                .filter(move |start| start + length <= samples)
                .map(move |start| whole.view().part(start..start + length))
        })
    }

    /// Its windows to fit, overlapping. The last ones are shorter, so that the end of the recording counts too.
    pub fn overlapping(&self) -> impl Iterator<Item = RunView<'_>> {
        let Cut { window, every, .. } = self.cut;
        self.whole.iter().flat_map(move |whole| {
            let samples = whole.samples();
            // A remainder that is shorter than a step belongs to the windows before it.
            let starts = (0..samples).step_by(every).filter(move |k| *k == 0 || k + every <= samples);
            starts.map(move |start| whole.view().part(start..(start + window).min(samples)))
        })
    }

    /// Number of its windows that models are scored on, side by side.
    pub fn windows(&self) -> usize {
        self.scored(Laid::SideBySide).count()
    }

    /// Number of its samples.
    pub fn samples(&self) -> usize {
        self.whole.iter().map(Part::samples).sum()
    }

    /// Number of errors in its windows.
    pub fn errors(&self) -> f64 {
        self.overlapping().map(|window| 3 * window.samples()).sum::<usize>() as f64
    }

    /// The kind of trial: its name up to the first digit or sign, or its maneuver's.
    pub fn kind(&self) -> &str {
        let end = self.name.find(|c: char| !c.is_alphabetic()).unwrap_or(self.name.len());
        &self.name[..end]
    }
}

/// The fold of each of `recordings`, below `count`. Those of one kind are dealt out one to each fold in turn, so that each fold has
/// some of every kind. The longest come first, each to the fold with the fewest samples so far, so that folds are
/// about equally long.
pub fn folds(recordings: &[&Recording], count: usize) -> Vec<usize> {
    let samples = |i: &usize| recordings[*i].samples();
    let kind = |i: &usize| recordings[*i].kind();
    let mut order: Vec<usize> = (0..recordings.len()).collect();
    order.sort_by_key(|i| (kind(i), Reverse(samples(i))));
    let (mut folds, mut samples_by_fold) = (vec![0; recordings.len()], vec![0; count]);
    for of_one_kind in order.chunk_by(|a, b| kind(a) == kind(b)) {
        let mut dealt = vec![0_usize; count];
        for recording in of_one_kind {
            let least = (0..count).min_by_key(|fold| (dealt[*fold], samples_by_fold[*fold]));
            let fold = least.unwrap_or(0);
            dealt[fold] += 1;
            samples_by_fold[fold] += samples(recording);
            folds[*recording] = fold;
        }
    }
    folds
}

/// Squared errors of u, v, r over a window; `None` for one that exceeds the limits.
type Squares = Option<[f64; 3]>;

/// A structure with its parameters.
pub(crate) type Numbered<'a> = (&'a Model, &'a [f64]);

/// Standard deviations of u, v, r over the windows of `recordings` that models are scored on.
fn varying<'r>(recordings: impl Iterator<Item = &'r Recording> + Clone, laid: Laid) -> [f64; 3] {
    deviations(recordings.flat_map(move |r| r.scored(laid)).map(|window| window.measured))
}

/// Scores `model` with `theta` on each of `recordings`; a window in which it exceeds `limit` counts as diverged.
fn scores(model: &Model, theta: &[f64], runs: &[&Recording], laid: Laid, limit: [f64; 3]) -> Vec<Score> {
    let theta = lanes(theta);
    scored(runs, laid, |windows| squares(model, &theta, windows, limit))
}

fn scores_of_mean(models: &[Numbered], recordings: &[&Recording], laid: Laid, limit: [f64; 3]) -> Vec<Score> {
    let models: Vec<(&Model, Vec<Lane>)> =
        models.iter().map(|(model, theta)| (*model, lanes(theta))).collect();
    scored(recordings, laid, |windows| squares_of_mean(&models, windows, limit))
}

fn lanes(theta: &[f64]) -> Vec<Lane> {
    theta.iter().copied().map(Lane::splat).collect()
}

fn scored(runs: &[&Recording], laid: Laid, square: impl Fn(&[RunView]) -> Vec<Squares> + Sync) -> Vec<Score> {
    let of = |recording: &&Recording| {
        let windows: Vec<RunView> = recording.scored(laid).collect();
        let mut score = Score::default();
        for group in windows.chunks(LANES) {
            for (window, errors) in group.iter().zip(square(group)) {
                match errors {
                    Some(squares) => {
                        (0..3).for_each(|d| score.squares[d] += squares[d]);
                        score.samples += window.samples() as u64;
                    }
                    None => score.diverged += 1,
                }
            }
        }
        score
    };
    runs.par_iter().map(of).collect()
}

fn together<'s>(scores: impl Iterator<Item = &'s Score>) -> Score {
    scores.fold(Score::default(), |mut all, score| {
        all.merge(score);
        all
    })
}

/// Mean fit of the states that vary \[%\]; `None` if a window diverged or there is no window.
fn mean_fit(score: &Score, std: [f64; 3]) -> Option<f64> {
    mean_of(&score.errors(std)?)
}

fn mean_of(errors: &FreeRunErrors) -> Option<f64> {
    mean(&errors.fits().into_iter().flatten().collect::<Vec<_>>())
}

/// Standard error of the mean fit over all of `scores`, by leaving each out in turn.
fn standard_error(scores: &[Score], std: [f64; 3]) -> Option<f64> {
    let others = |i: usize| scores.iter().enumerate().filter(move |(j, _)| *j != i).map(|(_, score)| score);
    let without: Vec<f64> = (0..scores.len()).filter_map(|i| mean_fit(&together(others(i)), std)).collect();
    let n = without.len() as f64;
    spread(&without).map(|spread| spread * (n - 1.0) / n.sqrt())
}

/// A simulation has failed if it exceeds the largest measured state times this.
const BEYOND: f64 = 5.0;

/// Squared errors of u, v, r of up to [`LANES`] windows; `None` for one that exceeds `limit`.
pub(crate) fn squares(model: &Model, theta: &[Lane], windows: &[RunView], limit: [f64; 3]) -> Vec<Squares> {
    let runs = SideBySide::of(windows);
    errors(&states(model, theta, &runs), &runs, limit)
}

/// Squared errors of the mean trajectory of several models; `None` for a window in which one of them exceeds `limit`.
pub(crate) fn squares_of_mean(
    models: &[(&Model, Vec<Lane>)],
    windows: &[RunView],
    limit: [f64; 3],
) -> Vec<Squares> {
    let runs = SideBySide::of(windows);
    let mut within = vec![true; windows.len()];
    let mut mean = MeanTrajectory::default();
    for (model, theta) in models {
        let simulated = states(model, theta, &runs);
        let squares_of_model = errors(&simulated, &runs, limit);
        within.iter_mut().zip(squares_of_model).for_each(|(within, squares)| *within &= squares.is_some());
        mean.add(&simulated);
    }
    let squares_of_all = errors(mean.mean(), &runs, limit);
    squares_of_all.into_iter().zip(within).map(|(squares, within)| squares.filter(|_| within)).collect()
}

fn states(model: &Model, theta: &[Lane], runs: &SideBySide) -> Vec<Lane> {
    let mut states = vec![Lane::ZERO; runs.measured.len()];
    simulate(model, theta, runs.initial, &runs.exogenous, &Weather::CALM, &mut states);
    states
}

fn errors(states: &[Lane], runs: &SideBySide, limit: [f64; 3]) -> Vec<Squares> {
    let mut sums = vec![Some([0.0; 3]); runs.runs];
    for (i, (state, measured)) in states.iter().zip(&runs.measured).enumerate().skip(3) {
        let (k, d) = (i / 3, i % 3);
        for (lane, sum) in sums.iter_mut().enumerate().filter(|(lane, _)| k <= runs.samples[*lane]) {
            // NaN exceeds it too.
            let within = state[lane].abs() <= limit[d];
            *sum = sum.filter(|_| within).map(|mut sum: [f64; 3]| {
                sum[d] += (measured[lane] - state[lane]).powi(2);
                sum
            });
        }
    }
    sums
}

pub(crate) fn limit(recordings: &[&Recording]) -> [f64; 3] {
    let mut largest = [0.0_f64; 3];
    for row in recordings.iter().flat_map(|r| &r.whole).flat_map(|p| p.measured.as_chunks::<3>().0) {
        (0..3).for_each(|d| largest[d] = largest[d].max(row[d].abs()));
    }
    largest.map(|largest| BEYOND * largest)
}
