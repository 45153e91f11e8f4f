//! What disturbs runs where nobody says so: by the likelihood of the runs themselves.

use engine::RunView;
use model::Model;
use numerics::distributions::student_half_width;

use super::criticise::verdicts;
use super::found::Verdict;
use super::listened::heard;
use super::noise::Kinds;
use super::problems::{Problems, Subject};
use crate::sensitivity::Levels;

/// Samples below which noise is not known well enough to choose one kind.
const SHORT: usize = 500;
/// Samples for each degree of freedom of Student's t, and the least of these: levels of noise are found from the run as well.
const FREEDOM: [f64; 2] = [18.5, 13.0];

/// What standard errors of runs of so many samples are multiplied with, for intervals of 95 % by the normal distribution's 1.96.
fn student(samples: usize) -> f64 {
    student_half_width((samples as f64 / FREEDOM[0]).max(FREEDOM[1])) / 1.959_964
}

/// Noise of runs, found in turns with parameters of a model.
#[derive(Clone, Debug)]
pub(crate) struct Calibrated {
    /// The noise.
    pub levels: Levels,
    /// The parameters under it.
    pub parameters: Vec<f64>,
    /// Standard errors of them where runs are short: the largest among all kinds of noise that may be the right one.
    pub widest: Option<Vec<f64>>,
    /// The levels of these kinds; of the best one alone where runs are long enough.
    pub near: Vec<Levels>,
    /// What standard errors under these are multiplied with.
    pub factor: f64,
    /// Whether the errors follow this noise.
    pub white: bool,
    /// All kinds of noise, the likeliest first.
    pub kinds: Kinds,
}

/// Noise and parameters of `runs` under `model`, which start at states that may be known, from the first of `starts` that leads
/// to any.
pub(crate) fn calibrated(
    model: &Model,
    runs: &[RunView],
    rate_hz: f64,
    known_start: bool,
    starts: &[Vec<f64>],
) -> Option<Calibrated> {
    let subject = Subject { model, runs, rate_hz, known_start, levels: None, names: &[] };
    let problems = Problems::new(&subject, true);
    let state = heard(&problems, 0, starts, &[])?;
    let noise = state.noise.clone()?;
    let (parameters, kinds) = (state.parameters.clone(), noise.kinds.clone());
    let verdict = verdicts(&subject, &problems, vec![state]).pop().flatten();
    let samples = runs.iter().map(RunView::samples).sum();
    let (short, factor) = (samples < SHORT, student(samples));
    let levels = noise.guess.levels(rate_hz);
    let near = match short {
        true => noise.near().map(|guess| guess.levels(rate_hz)).collect(),
        false => vec![levels],
    };
    Some(Calibrated {
        levels,
        parameters,
        widest: short.then(|| noise.widest.clone()),
        near,
        factor,
        white: verdict.is_some_and(|found| found.verdict != Verdict::None),
        kinds,
    })
}
