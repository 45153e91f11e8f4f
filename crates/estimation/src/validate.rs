use numerics::{Arithmetic, GROUPS, LANES, Lane, Number, Numbers, Row, Wide, vectorized};
use refusal::listed;
use regression::pooled::{Part, Regression};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use ship::engine::{
    Compiled, Replayed, Run, RunView, Weather, check_diverged, diverged_lanes, replay, simulate,
};
use ship::model::{Model, Vessel};

use crate::{EstimateStatus, Estimator, RunEstimate, ScoreStatus};

/// Errors of a free simulation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FreeRun {
    /// Root mean square over samples 1 to N of the difference in u, v \[m/s\] and r \[rad/s\].
    Rmse([f64; 3]),
    /// The simulation diverged at this sample.
    Diverged(usize),
}

impl FreeRun {
    /// The 2-norm of the three errors, as numbers; `None` if it diverged.
    pub fn norm(&self) -> Option<f64> {
        match self {
            Self::Rmse(rmse) => Some(rmse_norm(*rmse)),
            Self::Diverged(_) => None,
        }
    }
}

/// The 2-norm of RMSE in u, v, r, as numbers.
pub fn rmse_norm(rmse: [f64; 3]) -> f64 {
    rmse.iter().map(|e| e * e).sum::<f64>().sqrt()
}

/// Simulates [`LANES`] models freely over the inputs of a validation run and compares with its states.
///
/// `theta`: one lane per parameter. `rows`: N × exogenous. `truth`: (N+1) × 3 states; the simulation starts
/// at the first.
pub fn free_runs(model: &Model, theta: &[Lane], rows: &[impl Number], truth: &[f64]) -> [FreeRun; LANES] {
    runs_over(model, theta, Number::numbers(rows), truth)
}

fn runs_over(model: &Model, parameters: &[Lane], exogenous: Numbers, reference: &[f64]) -> [FreeRun; LANES] {
    let parameters: Vec<Wide<1>> = parameters.iter().copied().map(Wide::from).collect();
    let [runs] = match exogenous {
        Numbers::Lanes(lanes) => free_runs_of(model, &parameters, lanes, reference),
        Numbers::Shared(numbers) => free_runs_of(model, &parameters, numbers, reference),
    };
    runs
}

/// [`free_runs`] of `G` times as many models.
fn free_runs_of<const G: usize, E: Number>(
    model: &Model,
    parameters: &[Wide<G>],
    exogenous: &[E],
    reference: &[f64],
) -> [[FreeRun; LANES]; G]
where
    for<'a> &'a [E]: Row<Wide<G>>,
{
    let mut compiled = Compiled::new(model, parameters);
    let (squares, beyond) =
        vectorized!(squared_errors(&mut compiled, model.exogenous(), exogenous, reference));
    let samples = (reference.len() / 3 - 1) as f64;
    let initial = [0, 1, 2].map(|d| Lane::splat(reference[d]));
    let first_beyond = |group: usize, lane: usize| {
        let theta: Vec<Lane> = parameters.iter().map(|p| Lane::splat(p.0[group][lane])).collect();
        let mut states = vec![Lane::ZERO; reference.len()];
        simulate(model, &theta, initial, exogenous, &Weather::CALM, &mut states);
        diverged_lanes(&states)[0].map_or(0, |at| at.sample)
    };
    std::array::from_fn(|group| {
        std::array::from_fn(|lane| match beyond[group][lane] > 0.0 {
            true => FreeRun::Diverged(first_beyond(group, lane)),
            false => FreeRun::Rmse(squares.map(|s| (s.0[group][lane] / samples).sqrt())),
        })
    })
}

/// Sums of squared errors of u, v and r, and a positive number if one of them exceeded the bound.
#[inline(always)]
fn squared_errors<const G: usize, E: Number>(
    model: &mut Compiled<Wide<G>>,
    width: usize,
    exogenous: &[E],
    reference: &[f64],
) -> ([Wide<G>; 3], [Lane; G])
where
    for<'a> &'a [E]: Row<Wide<G>>,
{
    let mut state = [0, 1, 2].map(|d| Wide::from(reference[d]));
    let (mut squares, mut beyond) = ([Wide::ZERO; 3], [Lane::ZERO; G]);
    for (exogenous, truth) in exogenous.chunks_exact(width.max(1)).zip(reference[3..].chunks_exact(3)) {
        model.advance(
            &mut state,
            exogenous,
            #[inline(always)]
            |_| [0.0; 2],
        );
        for d in 0..3 {
            let error = state[d] - Wide::from(truth[d]);
            squares[d] += error * error;
            beyond
                .iter_mut()
                .zip(state[d].0)
                .for_each(|(beyond, state)| ship::engine::mark_beyond(beyond, state));
        }
    }
    (squares, beyond)
}

/// The 2-norm over the parameters of (θ̂ − θ)/θ, of θ̂ itself where θ is zero.
pub fn parameter_error(estimate: &[f64], truth: &[f64]) -> f64 {
    let relative = estimate.iter().zip(truth).map(|(e, t)| if *t == 0.0 { *e } else { (e - t) / t });
    relative.map(|x| x * x).sum::<f64>().sqrt()
}

/// Names the parameters of `vessel` whose errors [`parameter_error`] does not relate to their true value.
pub fn not_relative(vessel: &Vessel) -> Option<String> {
    let all = vessel.model.parameter_names().zip(&vessel.value);
    let zero: Vec<String> =
        all.filter(|(_, v)| **v == Some(0.0)).map(|(name, _)| format!("`{name}`")).collect();
    (!zero.is_empty()).then(|| {
        format!(
            "in the parameter error {} with a true value of 0 counts as estimated, not relative to it",
            listed(&zero)
        )
    })
}

/// The score of an estimate in free simulations over the validation runs.
#[derive(Clone, Debug, PartialEq)]
pub struct RunScore {
    /// The design of the run that was estimated.
    pub design: String,
    /// Its number.
    pub run: i32,
    /// The estimator.
    pub estimator: Estimator,
    /// The status of its model.
    pub status: ScoreStatus,
    /// ‖(θ̂ − θ)/θ‖, if there is an estimate and the truth is known.
    pub parameter_error: Option<f64>,
    /// RMSE in u, v \[m/s\] and r \[rad/s\], if the simulation did not diverge.
    pub rmse: [Option<f64>; 3],
    /// Their norm.
    pub simulation_error: Option<f64>,
}

/// A candidate to be scored: its origin, and θ̂ if there is one.
#[derive(Clone, Copy, Debug)]
pub struct EstimateView<'a> {
    /// The design of the run that was estimated.
    pub design: &'a str,
    /// Its number.
    pub run: i32,
    /// The estimator.
    pub estimator: Estimator,
    /// Whether there is an estimate, and if not, why.
    pub status: EstimateStatus,
    /// θ̂: surge, sway, yaw.
    pub parameters: Option<&'a [f64]>,
}

impl<'a> From<&'a RunEstimate> for EstimateView<'a> {
    fn from(run_estimate: &'a RunEstimate) -> Self {
        let RunEstimate { design, run, estimator, status, estimate, .. } = run_estimate;
        let parameters = estimate.as_ref().map(|(theta, _)| theta.as_slice());
        Self { design, run: *run, estimator: *estimator, status: *status, parameters }
    }
}

/// The validation runs, ready to be simulated by several models at once.
pub struct ValidationRuns<'a> {
    vessel: &'a Vessel,
    runs: Vec<Run>,
}

impl<'a> ValidationRuns<'a> {
    /// From `runs`; `None` without any.
    pub fn new(vessel: &'a Vessel, runs: Vec<Run>) -> Option<Self> {
        (!runs.is_empty()).then_some(Self { vessel, runs })
    }

    /// Samples of all runs together.
    pub fn samples(&self) -> u64 {
        self.runs.iter().map(|run| run.samples() as u64).sum()
    }

    /// Scores of `estimates`; parameter errors if the `truth` is known.
    pub fn score(&self, estimates: &[RunEstimate], truth: Option<&[f64]>) -> Vec<RunScore> {
        self.scores(&estimates.iter().map(EstimateView::from).collect::<Vec<_>>(), truth)
    }

    /// [`Self::score`] of candidates.
    pub fn scores(&self, candidates: &[EstimateView], truth: Option<&[f64]>) -> Vec<RunScore> {
        let some = |chunk: &[EstimateView]| match chunk.len() {
            0..=LANES => self.score_all::<1>(chunk, truth),
            _ => self.score_all::<GROUPS>(chunk, truth),
        };
        candidates.chunks(GROUPS * LANES).flat_map(some).collect()
    }

    fn score_all<const G: usize>(&self, candidates: &[EstimateView], truth: Option<&[f64]>) -> Vec<RunScore> {
        let model = &self.vessel.model;
        let zero = vec![0.0; model.parameters()];
        let of = |i: usize| candidates[i.min(candidates.len() - 1)].parameters.unwrap_or(&zero);
        let lane = |group: usize, p: usize| Lane(std::array::from_fn(|lane| of(group * LANES + lane)[p]));
        let parameters: Vec<Wide<G>> =
            (0..zero.len()).map(|p| Wide(std::array::from_fn(|group| lane(group, p)))).collect();
        let mut errors = vec![Some([0.0; 3]); candidates.len()];
        for run in &self.runs {
            let runs = free_runs_of(model, &parameters, &run.exogenous, &run.measured);
            for (total, free_run) in errors.iter_mut().zip(runs.as_flattened()) {
                *total = add(*total, *free_run, run.samples() as f64);
            }
        }
        let each = candidates.iter().zip(errors);
        each.map(|(candidate, error)| self.scored(candidate, error, truth)).collect()
    }

    fn scored(&self, candidate: &EstimateView, squares: Option<[f64; 3]>, truth: Option<&[f64]>) -> RunScore {
        let samples = self.samples() as f64;
        let rmse =
            squares.filter(|_| candidate.parameters.is_some()).map(|s| s.map(|x| (x / samples).sqrt()));
        let status = match (candidate.parameters, rmse) {
            (None, _) if candidate.status == EstimateStatus::NotConverged => ScoreStatus::NotConverged,
            (None, _) => ScoreStatus::NotIdentifiable,
            (Some(_), None) => ScoreStatus::Diverged,
            (Some(_), Some(_)) => ScoreStatus::Scored,
        };
        let known = candidate.parameters.zip(truth);
        RunScore {
            design: candidate.design.to_owned(),
            run: candidate.run,
            estimator: candidate.estimator,
            status,
            parameter_error: known.map(|(theta, truth)| parameter_error(theta, truth)),
            rmse: [0, 1, 2].map(|d| rmse.map(|r| r[d])),
            simulation_error: rmse.map(rmse_norm),
        }
    }
}

fn add(total: Option<[f64; 3]>, free_run: FreeRun, samples: f64) -> Option<[f64; 3]> {
    match free_run {
        FreeRun::Rmse(rmse) => total.map(|t| [0, 1, 2].map(|d| t[d] + rmse[d] * rmse[d] * samples)),
        FreeRun::Diverged(_) => None,
    }
}

/// Squared errors of free simulations over several windows.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Score {
    /// Sum of squared errors in u, v, r over the windows that did not diverge.
    pub squares: [f64; 3],
    /// Their samples.
    pub samples: u64,
    /// Windows that diverged.
    pub diverged: u64,
}

impl Score {
    /// Simulates `model` with `parameters` over all `windows`.
    pub fn of<'a>(model: &Model, parameters: &[f64], windows: impl Iterator<Item = RunView<'a>>) -> Self {
        let lanes: Vec<Lane> = parameters.iter().copied().map(Lane::splat).collect();
        let mut score = Self::default();
        for window in windows {
            let [first, ..] = free_runs(model, &lanes, window.exogenous, window.measured);
            score.add(first, window.samples());
        }
        score
    }

    /// Adds a window of `samples` samples.
    pub fn add(&mut self, free_run: FreeRun, samples: usize) {
        match free_run {
            FreeRun::Rmse(rmse) => {
                let n = samples as f64;
                self.squares.iter_mut().zip(rmse).for_each(|(s, e)| *s += n * e * e);
                self.samples += samples as u64;
            }
            FreeRun::Diverged(_) => self.diverged += 1,
        }
    }

    /// Simulates `model` over all `windows`, one after the other, as [`replay`] does.
    pub fn replayed<'a>(
        model: &Model,
        parameters: &[f64],
        windows: impl Iterator<Item = RunView<'a>>,
        are_inputs_held: bool,
    ) -> Self {
        let mut score = Self::default();
        for window in windows {
            let states = replay(model, parameters, window.initial, window.exogenous, are_inputs_held);
            score.add_states(&states, window);
        }
        score
    }

    /// Adds a simulation of `window` from its first measured state: u, v, r row by row.
    pub fn add_states(&mut self, states: &[f64], window: RunView) {
        if check_diverged(states.iter().copied()).is_some() {
            self.diverged += 1;
            return;
        }
        self.samples += window.samples() as u64;
        for (i, (state, measured)) in states.iter().zip(window.measured).enumerate().skip(3) {
            self.squares[i % 3] += (state - measured).powi(2);
        }
    }

    /// Adds other windows.
    pub fn merge(&mut self, other: &Self) {
        self.squares.iter_mut().zip(other.squares).for_each(|(s, o)| *s += o);
        self.samples += other.samples;
        self.diverged += other.diverged;
    }

    /// RMSE in u, v \[m/s\], r \[rad/s\]; `None` if a window diverged or there is none.
    pub fn rmse(&self) -> Option<[f64; 3]> {
        let whole = self.diverged == 0 && self.samples > 0;
        whole.then(|| self.squares.map(|s| (s / self.samples as f64).sqrt()))
    }

    /// Errors against the standard deviations `std` of the measured states (see [`deviations`]); `None` as [`Score::rmse`].
    pub fn errors(&self, std: [f64; 3]) -> Option<FreeRunErrors> {
        let rmse = self.rmse()?;
        let fit = |d: usize| (std[d] > 0.0).then(|| 100.0 * (1.0 - rmse[d] / std[d]));
        let ([rmse_u, rmse_v, rmse_r], [fit_u, fit_v, fit_r]) = (rmse, [0, 1, 2].map(fit));
        Some(FreeRunErrors { rmse_u, rmse_v, rmse_r, fit_u, fit_v, fit_r })
    }

    /// The 2-norm of RMSE/std; `None` as [`Score::rmse`], and if a state does not vary.
    pub fn norm(&self, std: [f64; 3]) -> Option<f64> {
        let rmse = self.rmse()?;
        let norm = (0..3).map(|d| (rmse[d] / std[d]).powi(2)).sum::<f64>().sqrt();
        norm.is_finite().then_some(norm)
    }
}

/// Errors of free simulations. Fit: 100 (1 − RMSE/std), 0 as good as the mean of the data.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FreeRunErrors {
    /// Of surge speed.
    pub rmse_u: f64,
    /// Of sway speed.
    pub rmse_v: f64,
    /// Of yaw rate.
    pub rmse_r: f64,
    /// Of surge speed; null where it does not vary.
    pub fit_u: Option<f64>,
    /// Of sway speed.
    pub fit_v: Option<f64>,
    /// Of yaw rate.
    pub fit_r: Option<f64>,
}

impl FreeRunErrors {
    /// Fits of u, v, r.
    pub fn fits(&self) -> [Option<f64>; 3] {
        [self.fit_u, self.fit_v, self.fit_r]
    }
}

/// Standard deviations of u, v, r over samples 1 to N of several (N+1) × 3 states, as of a whole population.
pub fn deviations<'a>(measured: impl Iterator<Item = &'a [f64]> + Clone) -> [f64; 3] {
    let mut means = StateMeans::default();
    measured.clone().for_each(|states| means.add(states));
    let mut deviations = means.deviations();
    measured.for_each(|states| deviations.add(states));
    deviations.std()
}

/// Σ u, Σ v, Σ r over samples 1 to N of several (N+1) × 3 states.
#[derive(Clone, Copy, Debug)]
pub(crate) struct StateMeans {
    rows: usize,
    sums: [f64; 3],
}

#[derive(Clone, Copy, Debug)]
pub(crate) struct StateDeviations {
    rows: usize,
    means: [f64; 3],
    squares: [f64; 3],
}

impl Default for StateMeans {
    fn default() -> Self {
        // The start value of `Iterator::sum`, so that sums part by part have the same bits.
        Self { rows: 0, sums: [std::iter::empty::<f64>().sum(); 3] }
    }
}

impl StateMeans {
    pub(crate) fn add(&mut self, states: &[f64]) {
        for row in states.chunks_exact(3).skip(1) {
            self.rows += 1;
            (0..3).for_each(|d| self.sums[d] += row[d]);
        }
    }

    pub(crate) fn deviations(&self) -> StateDeviations {
        let means = self.sums.map(|sum| sum / self.rows as f64);
        StateDeviations { rows: self.rows, means, squares: Self::default().sums }
    }
}

impl StateDeviations {
    pub(crate) fn add(&mut self, states: &[f64]) {
        for row in states.chunks_exact(3).skip(1) {
            (0..3).for_each(|d| self.squares[d] += (row[d] - self.means[d]) * (row[d] - self.means[d]));
        }
    }

    pub(crate) fn std(&self) -> [f64; 3] {
        let n = self.rows as f64;
        let of = |squares: f64| (squares / (n - 1.0)).sqrt() * ((n - 1.0) / n).sqrt();
        if self.rows > 1 { self.squares.map(of) } else { [0.0; 3] }
    }
}

/// What a step from each measured state of `part` leaves of the next one: u, v \[m/s\] and r \[rad/s\], a row per sample. Inputs are
/// linear between samples unless they are held; where there are regressors, they are held.
pub fn one_step_errors(model: &Model, theta: &[f64], part: &Part, are_inputs_held: bool) -> [Vec<f64>; 3] {
    let Some(moved) = &model.forces else {
        let (regression, layout) = (Regression::of(model, &part.whole()), model.layout());
        return [0, 1, 2].map(|d: usize| regression.degrees[d].residuals(&theta[layout.terms(d)]).collect());
    };
    let course = (&part.exogenous[..], model.exogenous().max(1));
    let replayed = Replayed::new(moved, theta, course, are_inputs_held);
    let states = part.measured.as_chunks::<3>().0;
    let left = |k: usize, d: usize| states[k + 1][d] - replayed.step(k, states[k])[d];
    [0, 1, 2].map(|d| (0..part.samples()).map(|k| left(k, d)).collect())
}
