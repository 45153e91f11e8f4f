use numerics::{GROUPS, LANES, Lane, Wide};
use ship::engine::Run;
use ship::model::Vessel;

use crate::validate::{free_runs_of, rmse_norm};
use crate::{EstimateStatus, Estimator, FreeRun, RunEstimate, ScoreStatus, parameter_error};

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
pub struct Candidate<'a> {
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

impl<'a> From<&'a RunEstimate> for Candidate<'a> {
    fn from(found: &'a RunEstimate) -> Self {
        let RunEstimate { design, run, estimator, status, estimate, .. } = found;
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
        self.scores(&estimates.iter().map(Candidate::from).collect::<Vec<_>>(), truth)
    }

    /// [`Self::score`] of candidates.
    pub fn scores(&self, candidates: &[Candidate], truth: Option<&[f64]>) -> Vec<RunScore> {
        let some = |chunk: &[Candidate]| match chunk.len() {
            0..=LANES => self.score_groups::<1>(chunk, truth),
            _ => self.score_groups::<GROUPS>(chunk, truth),
        };
        candidates.chunks(GROUPS * LANES).flat_map(some).collect()
    }

    fn score_groups<const G: usize>(&self, candidates: &[Candidate], truth: Option<&[f64]>) -> Vec<RunScore> {
        let model = &self.vessel.model;
        let zero = vec![0.0; model.parameters()];
        let of = |i: usize| candidates[i.min(candidates.len() - 1)].parameters.unwrap_or(&zero);
        let lane = |group: usize, p: usize| Lane(std::array::from_fn(|lane| of(group * LANES + lane)[p]));
        let parameters: Vec<Wide<G>> =
            (0..zero.len()).map(|p| Wide(std::array::from_fn(|group| lane(group, p)))).collect();
        let mut errors = vec![Some([0.0; 3]); candidates.len()];
        for run in &self.runs {
            let found = free_runs_of(model, &parameters, &run.exogenous, &run.measured);
            for (total, found) in errors.iter_mut().zip(found.as_flattened()) {
                *total = add(*total, *found, run.samples() as f64);
            }
        }
        let each = candidates.iter().zip(errors);
        each.map(|(candidate, error)| self.scored(candidate, error, truth)).collect()
    }

    fn scored(&self, found: &Candidate, squares: Option<[f64; 3]>, truth: Option<&[f64]>) -> RunScore {
        let samples = self.samples() as f64;
        let rmse = squares.filter(|_| found.parameters.is_some()).map(|s| s.map(|x| (x / samples).sqrt()));
        let status = match (found.parameters, rmse) {
            (None, _) if found.status == EstimateStatus::NotConverged => ScoreStatus::NotConverged,
            (None, _) => ScoreStatus::NotIdentifiable,
            (Some(_), None) => ScoreStatus::Diverged,
            (Some(_), Some(_)) => ScoreStatus::Scored,
        };
        let known = found.parameters.zip(truth);
        RunScore {
            design: found.design.to_owned(),
            run: found.run,
            estimator: found.estimator,
            status,
            parameter_error: known.map(|(theta, truth)| parameter_error(theta, truth)),
            rmse: [0, 1, 2].map(|d| rmse.map(|r| r[d])),
            simulation_error: rmse.map(rmse_norm),
        }
    }
}

/// Adds the squared errors of one run; `None` once any diverged.
fn add(total: Option<[f64; 3]>, found: FreeRun, samples: f64) -> Option<[f64; 3]> {
    match found {
        FreeRun::Rmse(rmse) => total.map(|t| [0, 1, 2].map(|d| t[d] + rmse[d] * rmse[d] * samples)),
        FreeRun::Diverged(_) => None,
    }
}
