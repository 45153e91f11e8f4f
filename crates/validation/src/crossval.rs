//! Cross-validation: models simulated over runs or recordings that were left out of their estimate.

use estimation::pooled::{FreeRunErrors, NoEstimate, Pool, Score, deviations};
use estimation::{Contender, Estimator, Recommendation, ScoreStatus};
use rayon::prelude::*;
use refusal::{Invalid, listed};
use regression::pooled::{Drawn, Part, PooledRuns};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use ship::model::Model;
use thiserror::Error;

/// Why nothing can be left out.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum CrossError {
    /// There is only one run or recording, or all are left out.
    #[error("no run or recording that could be left out, or none that would be left")]
    OneSource,
    /// No run is as long as a window.
    #[error("no run is as long as a window")]
    NoWindow,
}

impl CrossError {
    /// What is invalid.
    pub fn invalid(&self) -> Invalid {
        let (wanted, remedy) = ("at least two, so that one can be left out", "add runs, or leave out fewer");
        match self {
            Self::OneSource => Invalid::new("runs or recordings", "one", wanted, remedy),
            Self::NoWindow => {
                Invalid::new("windows", "no run as long as a window", "at least one", "shorten --window-s")
            }
        }
    }
}

/// The places of so many runs or recordings that each of `folds` leaves out, dealt in turn; without a number each alone.
pub fn dealt(sources: usize, folds: Option<usize>) -> Vec<Vec<usize>> {
    let count = folds.unwrap_or(sources).min(sources);
    (0..count).map(|i| (i..sources).step_by(count.max(1)).collect()).collect()
}

/// Options of a cross-validation.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CrossOptions {
    /// The estimators.
    pub estimators: Vec<Estimator>,
    /// Length of the windows in samples; `None`: whole runs.
    pub window: Option<usize>,
    /// The number of folds that runs or recordings are dealt into; without it each is left out alone.
    pub folds: Option<usize>,
}

/// Estimators compared by free simulation over runs or recordings that were left out of the estimate.
#[derive(Clone, Debug, PartialEq)]
pub struct CrossValidation {
    /// Number of windows that were simulated.
    pub windows: u64,
    /// Their samples.
    pub samples: u64,
    /// Number of folds.
    pub folds: usize,
    /// Standard deviations of the measured u, v, r over the windows.
    pub std: [f64; 3],
    /// One per estimator.
    pub scores: Vec<EstimatorScore>,
    /// The estimators recording by recording, by their norms of RMSE/std; `None` if none could be simulated over all.
    pub recommendation: Option<Recommendation>,
    /// That, and what went wrong, in words.
    pub statements: Vec<String>,
}

/// One estimator over all folds.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct EstimatorScore {
    /// The estimator.
    pub name: Estimator,
    /// What became of its models.
    pub status: ScoreStatus,
    /// Why there are no errors.
    pub reason: Option<String>,
    /// Over all windows of all folds.
    pub errors: Option<FreeRunErrors>,
    /// Norm of RMSE/std.
    pub error_norm: Option<f64>,
    /// Windows that diverged.
    pub diverged: u64,
    /// Folds in which surge, sway, yaw were estimated with simulated instruments.
    pub by_instruments: [u64; 3],
    /// One entry per run or recording, when it was left out; against the standard deviations of its own states.
    pub sources: Vec<SourceScore>,
}

/// One estimator on one run or recording that was left out.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SourceScore {
    /// Its name.
    pub source: String,
    /// Windows of it.
    pub windows: u64,
    /// Windows that diverged.
    pub diverged: u64,
    /// Null where one diverged, there is no window, or no model.
    pub errors: Option<FreeRunErrors>,
    /// Norm of RMSE over the standard deviations of the states in all recordings, by which estimators are compared.
    pub error_norm: Option<f64>,
}

/// The data, cut for simulating.
struct Cut {
    windows: Vec<(String, Vec<Part>)>,
    std: [f64; 3],
}

/// One estimator in one fold.
#[derive(Default)]
struct Tried {
    scores: Vec<(usize, Score)>,
    by_instruments: [bool; 3],
    failed: Option<(ScoreStatus, String)>,
}

/// Leaves runs or recordings out, estimates from the others, simulates over those left out. `done` is called with the number
/// of estimates that are done.
///
/// # Errors
/// Nothing can be left out; no window.
pub fn cross_validate(
    pool: &Pool,
    runs: &PooledRuns,
    options: &CrossOptions,
    done: &(dyn Fn(usize) + Sync),
) -> Result<CrossValidation, CrossError> {
    let cut = Cut::new(runs, options.window)?;
    let folds = dealt(cut.windows.len(), options.folds);
    let parts = runs.parts(pool.part_samples);
    let score = |estimator: &Estimator| {
        let fold = |left_out: &Vec<usize>| {
            let tried = cut.fold(pool, &parts, left_out, *estimator);
            done(1);
            tried
        };
        let tried: Vec<Tried> = folds.par_iter().map(fold).collect();
        cut.score(*estimator, &tried)
    };
    let scores: Vec<EstimatorScore> = options.estimators.par_iter().map(score).collect();
    Ok(cut.validation(folds.len(), scores))
}

impl EstimatorScore {
    /// Its errors over the recordings with windows.
    fn contender(&self) -> Contender {
        let simulated = self.sources.iter().filter(|source| source.windows > 0);
        let errors: Vec<Option<f64>> = simulated.map(|source| source.error_norm).collect();
        // Without a model in some fold it has fewer recordings than the others.
        let complete = self.error_norm.is_some();
        let without_estimate = if complete { 0 } else { errors.len().max(1) };
        Contender { estimator: self.name, errors, without_estimate }
    }
}

impl Cut {
    /// Windows of so many samples, or whole runs.
    fn new(runs: &PooledRuns, window: Option<usize>) -> Result<Self, CrossError> {
        let windows = runs.windows(window);
        if windows.len() < 2 {
            return Err(CrossError::OneSource);
        }
        if windows.iter().all(|(_, parts)| parts.is_empty()) {
            return Err(CrossError::NoWindow);
        }
        let std = deviations(windows.iter().flat_map(|(_, parts)| parts).map(|w| w.measured.as_slice()));
        Ok(Self { windows, std })
    }

    /// All `scores` over so many folds.
    fn validation(&self, folds: usize, scores: Vec<EstimatorScore>) -> CrossValidation {
        let contenders: Vec<Contender> = scores.iter().map(EstimatorScore::contender).collect();
        let recommendation = Recommendation::new(&contenders);
        let windows = || self.windows.iter().flat_map(|(_, windows)| windows);
        CrossValidation {
            windows: windows().count() as u64,
            samples: windows().map(|w| w.samples() as u64).sum(),
            folds,
            std: self.std,
            statements: statements(recommendation.as_ref(), &scores),
            recommendation,
            scores,
        }
    }

    /// What became of `estimator` in all folds.
    fn score(&self, estimator: Estimator, tried: &[Tried]) -> EstimatorScore {
        let mut scores: Vec<&(usize, Score)> = tried.iter().flat_map(|t| &t.scores).collect();
        let mut whole = Score::default();
        scores.iter().for_each(|(_, score)| whole.merge(score));
        scores.sort_by_key(|(place, _)| *place);
        let failed = || tried.iter().filter_map(|t| t.failed.as_ref());
        let (status, reason) = match failed().next() {
            Some((status, why)) => {
                (*status, Some(format!("{} of {} folds, {why}", failed().count(), tried.len())))
            }
            None if whole.diverged > 0 => {
                (ScoreStatus::Diverged, Some(format!("{} windows diverge", whole.diverged)))
            }
            None => (ScoreStatus::Scored, None),
        };
        let complete = failed().next().is_none();
        EstimatorScore {
            name: estimator,
            status,
            reason,
            errors: whole.errors(self.std).filter(|_| complete),
            error_norm: whole.norm(self.std).filter(|_| complete),
            diverged: whole.diverged,
            by_instruments: [0, 1, 2]
                .map(|d: usize| tried.iter().filter(|t| t.by_instruments[d]).count() as u64),
            sources: scores.into_iter().map(|(place, score)| self.source(*place, score)).collect(),
        }
    }

    fn source(&self, place: usize, score: &Score) -> SourceScore {
        let (source, windows) = &self.windows[place];
        SourceScore {
            source: source.clone(),
            windows: windows.len() as u64,
            diverged: score.diverged,
            errors: score.errors(deviations(windows.iter().map(|w| w.measured.as_slice()))),
            error_norm: score.norm(self.std),
        }
    }

    fn fold(&self, pool: &Pool, parts: &Vec<Part>, left_out: &[usize], estimator: Estimator) -> Tried {
        let without: Vec<&str> = left_out.iter().map(|i| self.windows[*i].0.as_str()).collect();
        let places: Vec<usize> =
            (0..parts.len()).filter(|place| !without.contains(&parts[*place].source.as_str())).collect();
        let failed = |status, why: String| Some((status, format!("without {}: {why}", without.join(", "))));
        let estimated = match pool.estimate(&Drawn { parts, places: &places }, estimator) {
            Ok(estimated) => estimated,
            Err(NoEstimate::Lost(lost)) => {
                return Tried { failed: failed(ScoreStatus::Diverged, lost.to_string()), ..Tried::default() };
            }
        };
        let by_instruments = [0, 1, 2]
            .map(|d: usize| estimated.used[d].by_instruments() && estimated.degrees[d].solution.is_some());
        let tried = Tried { by_instruments, ..Tried::default() };
        if let Some(unfound) = &estimated.unfound {
            return Tried { failed: failed(ScoreStatus::NotConverged, unfound.to_string()), ..tried };
        }
        let Some(model) = estimated.parameters(&pool.model) else {
            let why = pool.unidentified(&estimated.degrees).join("; ");
            return Tried { failed: failed(ScoreStatus::NotIdentifiable, why), ..tried };
        };
        let windows = |source: usize| self.windows[source].1.iter().map(Part::view);
        let score = |source: &usize| (*source, Score::of(&pool.model, &model, windows(*source)));
        Tried { scores: left_out.iter().map(score).collect(), ..tried }
    }
}

fn statements(recommendation: Option<&Recommendation>, scores: &[EstimatorScore]) -> Vec<String> {
    let score = |name: Estimator| scores.iter().find(|score| score.name == name);
    let mut out = Vec::new();
    if let Some((chosen, errors)) = recommendation.and_then(|one| Some((one, score(one.least)?.errors?))) {
        out.push(verdict(chosen, &errors));
        let best = chosen.least;
        for other in scores.iter().filter(|e| e.name != best) {
            out.extend(other.errors.map(|e| format!("{best} over {}: {}", other.name, ahead(&errors, &e))));
        }
    }
    for failed in scores.iter().filter(|e| e.status != ScoreStatus::Scored) {
        out.push(format!("{}: {}: {}", failed.name, failed.status, failed.reason.as_deref().unwrap_or("")));
    }
    out
}

/// The recommended estimator, or those that cannot be distinguished.
fn verdict(chosen: &Recommendation, errors: &FreeRunErrors) -> String {
    let (least, fits) = (chosen.least, fits(errors));
    match chosen.estimator() {
        Some(_) => format!("recommended: {least} (fit {fits})"),
        None => {
            let close: Vec<String> = chosen.candidates()[1..].iter().map(Estimator::to_string).collect();
            format!(
                "none recommended: {least} (fit {fits}) has the least error, but the recordings cannot tell it from {}",
                listed(&close)
            )
        }
    }
}

/// `u +1.20, v +0.30, r -0.10 points of fit`.
fn ahead(best: &FreeRunErrors, other: &FreeRunErrors) -> String {
    let more = |d: usize| best.fits()[d].zip(other.fits()[d]).map(|(b, o)| b - o);
    let states = ["u", "v", "r"].into_iter().enumerate();
    let ahead: Vec<String> =
        states.filter_map(|(d, name)| more(d).map(|points| format!("{name} {points:+.2}"))).collect();
    format!("{} points of fit", ahead.join(", "))
}

/// `u 78.9 %, v 73.2 %, r 72.0 %`.
fn fits(errors: &FreeRunErrors) -> String {
    let one = |(name, fit): (&str, Option<f64>)| {
        fit.map_or_else(|| format!("{name} –"), |fit| format!("{name} {fit:.2} %"))
    };
    ["u", "v", "r"].into_iter().zip(errors.fits()).map(one).collect::<Vec<_>>().join(", ")
}

/// The free numbers of a ship that was fitted without the runs of these names, or why there are none.
pub type Fitting<'a> = &'a dyn Fn(&[String]) -> Result<Vec<f64>, String>;

/// As [`cross_validate`], of a ship with forces `model`: `fit` is called with the names of what is left out. Each fit has all threads.
///
/// # Errors
/// Nothing can be left out; no window.
pub fn cross_validate_forces(
    model: &Model,
    runs: &PooledRuns,
    (window, folds): (Option<usize>, Option<usize>),
    fit: Fitting,
    done: &(dyn Fn(usize) + Sync),
) -> Result<CrossValidation, CrossError> {
    let cut = Cut::new(runs, window)?;
    let folds = dealt(cut.windows.len(), folds);
    let held = runs.are_inputs_held();
    let tried = |left_out: &Vec<usize>| {
        let names: Vec<String> = left_out.iter().map(|place| cut.windows[*place].0.clone()).collect();
        let tried = match fit(&names) {
            Ok(theta) => {
                let score = |place: &usize| {
                    let windows = cut.windows[*place].1.iter().map(Part::view);
                    (*place, Score::replayed(model, &theta, windows, held))
                };
                Tried { scores: left_out.par_iter().map(score).collect(), ..Tried::default() }
            }
            Err(why) => {
                let why = format!("without {}: {why}", names.join(", "));
                Tried { failed: Some((ScoreStatus::NotConverged, why)), ..Tried::default() }
            }
        };
        done(1);
        tried
    };
    let tried: Vec<Tried> = folds.iter().map(tried).collect();
    let score = cut.score(Estimator::OutputError, &tried);
    Ok(cut.validation(folds.len(), vec![score]))
}
