//! Models in free simulation over validation runs.

use std::path::Path;

use artifact::Provenance;
use identification::{EstimateStatus, FreeRun, ScoreStatus, free_runs, parameter_error};
use vessel::{LANES, Vessel};

use crate::failure::Failure;
use study::estimates;
use study::scores::Row;
use study::trajectories::{Layout, TrajectoryReader};
use vessel::Run;
use vessel::lanes::interleave;

/// The validation runs, ready to be simulated by several models at once.
pub struct ValidationRuns<'a> {
    vessel: &'a Vessel,
    runs: Vec<Run>,
}

impl<'a> ValidationRuns<'a> {
    /// Reads the runs of `file` and notes its digest.
    ///
    /// # Errors
    /// A file that is refused, is a shard, or has no run.
    pub fn read(file: &Path, vessel: &'a Vessel, provenance: &mut Provenance) -> Result<Self, Failure> {
        let reader = TrajectoryReader::open(file, &Layout::new(&vessel.model), vessel.sample_rate_hz)?;
        reader.whole()?;
        provenance.inputs.insert("validation".into(), reader.digest());
        let mut runs = Vec::new();
        for block in 0..reader.blocks() {
            runs.extend(reader.runs(block)?);
        }
        if runs.is_empty() {
            return Err(Failure::refuse(
                file,
                "rows",
                "none",
                "at least one run",
                "simulate the validation again",
            ));
        }
        Ok(Self { vessel, runs })
    }

    /// Samples of all runs together.
    pub fn samples(&self) -> u64 {
        self.runs.iter().map(|run| run.samples() as u64).sum()
    }

    /// Scores of the models that `rows` estimated; parameter errors where the `truth` is known.
    pub fn score(&self, rows: &[estimates::Row], truth: Option<&[f64]>) -> Vec<Row> {
        rows.chunks(LANES).flat_map(|chunk| self.score_lanes(chunk, truth)).collect()
    }

    fn score_lanes(&self, rows: &[estimates::Row], truth: Option<&[f64]>) -> Vec<Row> {
        let zero = vec![0.0; self.vessel.model.parameters()];
        let own = |r: &'_ estimates::Row| r.estimate.as_ref().map(|(theta, _)| theta.clone());
        let parameters: Vec<Vec<f64>> = rows.iter().map(|r| own(r).unwrap_or_else(|| zero.clone())).collect();
        let lanes = interleave(&parameters.iter().map(Vec::as_slice).collect::<Vec<_>>());
        let mut errors = vec![Some([0.0; 3]); rows.len()];
        for run in &self.runs {
            let found = free_runs(&self.vessel.model, &lanes, &run.exogenous, &run.measured);
            for (total, found) in errors.iter_mut().zip(found) {
                *total = add(*total, found, run.samples() as f64);
            }
        }
        let score = |(row, error): (&estimates::Row, Option<[f64; 3]>)| self.row(row, error, truth);
        rows.iter().zip(errors).map(score).collect()
    }

    fn row(&self, row: &estimates::Row, squares: Option<[f64; 3]>, truth: Option<&[f64]>) -> Row {
        let samples = self.samples() as f64;
        let rmse = squares.filter(|_| row.estimate.is_some()).map(|s| s.map(|x| (x / samples).sqrt()));
        let status = match (&row.estimate, rmse) {
            (None, _) if row.status == EstimateStatus::NotConverged => ScoreStatus::NotConverged,
            (None, _) => ScoreStatus::NotIdentifiable,
            (Some(_), None) => ScoreStatus::Diverged,
            (Some(_), Some(_)) => ScoreStatus::Scored,
        };
        Row {
            design: row.design.clone(),
            run: row.run,
            estimator: row.estimator,
            status,
            parameter_error: row
                .estimate
                .as_ref()
                .zip(truth)
                .and_then(|((theta, _), truth)| parameter_error(theta, truth)),
            rmse: [0, 1, 2].map(|d| rmse.map(|r| r[d])),
            simulation_error: rmse.and_then(|r| FreeRun::Rmse(r).norm()),
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
