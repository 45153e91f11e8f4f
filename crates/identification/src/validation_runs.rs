use vessel::lanes::interleave;
use vessel::{LANES, Run, Vessel};

use crate::validate::rmse_norm;
use crate::{EstimateStatus, Estimator, FreeRun, RunEstimate, ScoreStatus, free_runs, parameter_error};

/// What an estimate is worth in free simulation over the validation runs.
#[derive(Clone, Debug, PartialEq)]
pub struct RunScore {
    /// The design of the run that was estimated.
    pub design: String,
    /// Its number.
    pub run: i32,
    /// The estimator.
    pub estimator: Estimator,
    /// What became of its model.
    pub status: ScoreStatus,
    /// ‖(θ̂ − θ)/θ‖, where there is an estimate and the truth is known.
    pub parameter_error: Option<f64>,
    /// RMSE in u, v \[m/s\] and r \[rad/s\], where the simulation did not diverge.
    pub rmse: [Option<f64>; 3],
    /// Their norm.
    pub simulation_error: Option<f64>,
}

/// The validation runs, ready to be simulated by several models at once.
pub struct ValidationRuns<'a> {
    vessel: &'a Vessel,
    runs: Vec<Run>,
}

impl<'a> ValidationRuns<'a> {
    /// Of `runs`; without any there is nothing to score.
    pub fn new(vessel: &'a Vessel, runs: Vec<Run>) -> Option<Self> {
        (!runs.is_empty()).then_some(Self { vessel, runs })
    }

    /// Samples of all runs together.
    pub fn samples(&self) -> u64 {
        self.runs.iter().map(|run| run.samples() as u64).sum()
    }

    /// Scores of `estimates`; parameter errors where the `truth` is known.
    pub fn score(&self, estimates: &[RunEstimate], truth: Option<&[f64]>) -> Vec<RunScore> {
        estimates.chunks(LANES).flat_map(|chunk| self.score_lanes(chunk, truth)).collect()
    }

    fn score_lanes(&self, estimates: &[RunEstimate], truth: Option<&[f64]>) -> Vec<RunScore> {
        let zero = vec![0.0; self.vessel.model.parameters()];
        let own = |r: &'_ RunEstimate| r.estimate.as_ref().map(|(theta, _)| theta.clone());
        let parameters: Vec<Vec<f64>> =
            estimates.iter().map(|r| own(r).unwrap_or_else(|| zero.clone())).collect();
        let lanes = interleave(&parameters.iter().map(Vec::as_slice).collect::<Vec<_>>());
        let mut errors = vec![Some([0.0; 3]); estimates.len()];
        for run in &self.runs {
            let found = free_runs(&self.vessel.model, &lanes, &run.exogenous, &run.measured);
            for (total, found) in errors.iter_mut().zip(found) {
                *total = add(*total, found, run.samples() as f64);
            }
        }
        let each = estimates.iter().zip(errors);
        each.map(|(estimate, error)| self.scored(estimate, error, truth)).collect()
    }

    fn scored(&self, found: &RunEstimate, squares: Option<[f64; 3]>, truth: Option<&[f64]>) -> RunScore {
        let samples = self.samples() as f64;
        let rmse = squares.filter(|_| found.estimate.is_some()).map(|s| s.map(|x| (x / samples).sqrt()));
        let status = match (&found.estimate, rmse) {
            (None, _) if found.status == EstimateStatus::NotConverged => ScoreStatus::NotConverged,
            (None, _) => ScoreStatus::NotIdentifiable,
            (Some(_), None) => ScoreStatus::Diverged,
            (Some(_), Some(_)) => ScoreStatus::Scored,
        };
        let known = found.estimate.as_ref().zip(truth);
        RunScore {
            design: found.design.clone(),
            run: found.run,
            estimator: found.estimator,
            status,
            parameter_error: known.and_then(|((theta, _), truth)| parameter_error(theta, truth)),
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
