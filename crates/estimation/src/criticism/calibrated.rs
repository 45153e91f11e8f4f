//! Disturbances of runs that do not state them: found by the likelihood of the runs.

use numerics::distributions::student_half_width;
use ship::engine::RunView;
use ship::model::Model;

use super::criticise::verdicts;
use super::found::Verdict;
use super::noise::Kinds;
use super::problems::{Problems, Subject};
use super::with_noise::with_noise;
use crate::sensitivity::NoiseModel;

/// With fewer samples, the noise is not known well enough to choose one kind.
const SHORT: usize = 500;
/// Samples per degree of freedom of Student's t, and the least number of degrees: the levels of noise are found from
/// the run too.
const FREEDOM: [f64; 2] = [18.5, 13.0];

/// Factor on standard errors of runs of `samples` samples, for 95 % intervals by the normal distribution's 1.96.
fn student(samples: usize) -> f64 {
    student_half_width((samples as f64 / FREEDOM[0]).max(FREEDOM[1])) / 1.959_964
}

/// Noise of runs, found alternately with parameters of a model.
#[derive(Clone, Debug)]
pub(crate) struct Calibrated {
    /// The noise.
    pub levels: NoiseModel,
    /// The parameters under it.
    pub parameters: Vec<f64>,
    /// Their standard errors if runs are short: the largest among all plausible kinds of noise.
    pub widest: Option<Vec<f64>>,
    /// The levels of these kinds; of the best one alone if runs are long enough.
    pub near: Vec<NoiseModel>,
    /// The factor on standard errors under these.
    pub factor: f64,
    /// Whether the errors follow this noise.
    pub white: bool,
    /// Whether waves move the ship, so that no standard errors hold.
    pub waves: bool,
    /// All kinds of noise, the likeliest first.
    pub kinds: Kinds,
}

/// Noise and parameters of `runs` under `model`, whose initial states may be known, from the first of `starts` that
/// succeeds.
pub(crate) fn calibrated(
    model: &Model,
    runs: &[RunView],
    rate_hz: f64,
    known_start: bool,
    starts: &[Vec<f64>],
) -> Option<Calibrated> {
    let subject = Subject { model, runs, rate_hz, known_start, levels: None, names: &[] };
    let problems = Problems::new(&subject, true);
    let state = with_noise(&problems, 0, starts, &[])?;
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
        white: verdict.as_ref().is_some_and(|found| found.verdict != Verdict::None),
        waves: verdict.is_some_and(|found| found.waves_s.is_some()),
        kinds,
    })
}
