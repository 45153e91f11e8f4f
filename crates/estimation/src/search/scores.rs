use crate::pooled::{FreeRunErrors, Score, deviations};
use numerics::statistics::{mean, spread};
use numerics::{LANES, Lane};
use rayon::prelude::*;
use ship::engine::RunView;
use ship::model::Model;

use crate::search::problem::{squares, squares_of_mean};
use crate::search::recording::{Laid, Recording};

/// Standard deviations of u, v, r over the windows of `recordings` that models are scored on.
pub(crate) fn varying<'r>(recordings: impl Iterator<Item = &'r Recording> + Clone, laid: Laid) -> [f64; 3] {
    deviations(recordings.flat_map(move |r| r.scored(laid)).map(|window| window.measured))
}

/// Scores `model` with `theta` on each of `recordings`; a window in which it exceeds `limit` counts as diverged.
pub(crate) fn scores(
    model: &Model,
    theta: &[f64],
    recordings: &[&Recording],
    laid: Laid,
    limit: [f64; 3],
) -> Vec<Score> {
    let theta = lanes(theta);
    scored(recordings, laid, |windows| squares(model, &theta, windows, limit))
}

/// Scores the mean trajectory of several `models` with their θ.
pub(crate) fn scores_of_mean(
    models: &[(&Model, &[f64])],
    recordings: &[&Recording],
    laid: Laid,
    limit: [f64; 3],
) -> Vec<Score> {
    let models: Vec<(&Model, Vec<Lane>)> =
        models.iter().map(|(model, theta)| (*model, lanes(theta))).collect();
    scored(recordings, laid, |windows| squares_of_mean(&models, windows, limit))
}

fn lanes(theta: &[f64]) -> Vec<Lane> {
    theta.iter().copied().map(Lane::splat).collect()
}

fn scored(
    recordings: &[&Recording],
    laid: Laid,
    squares: impl Fn(&[RunView]) -> Vec<Option<[f64; 3]>> + Sync,
) -> Vec<Score> {
    let of = |recording: &&Recording| {
        let windows: Vec<RunView> = recording.scored(laid).collect();
        let mut score = Score::default();
        for group in windows.chunks(LANES) {
            for (window, found) in group.iter().zip(squares(group)) {
                match found {
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
    recordings.par_iter().map(of).collect()
}

/// All of `scores` together.
pub(crate) fn together<'s>(scores: impl Iterator<Item = &'s Score>) -> Score {
    scores.fold(Score::default(), |mut all, own| {
        all.merge(own);
        all
    })
}

/// Mean fit of the states that vary \[%\]; `None` if a window diverged or there is no window.
pub(crate) fn mean_fit(score: &Score, std: [f64; 3]) -> Option<f64> {
    mean_of(&score.errors(std)?)
}

pub(crate) fn mean_of(errors: &FreeRunErrors) -> Option<f64> {
    mean(&errors.fits().into_iter().flatten().collect::<Vec<_>>())
}

/// Standard error of the mean fit over all of `scores`, by leaving each out in turn.
pub(crate) fn standard_error(scores: &[Score], std: [f64; 3]) -> Option<f64> {
    let others = |i: usize| scores.iter().enumerate().filter(move |(j, _)| *j != i).map(|(_, score)| score);
    let without: Vec<f64> = (0..scores.len()).filter_map(|i| mean_fit(&together(others(i)), std)).collect();
    let n = without.len() as f64;
    spread(&without).map(|spread| spread * (n - 1.0) / n.sqrt())
}
