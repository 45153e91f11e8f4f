use std::path::Path;

use identification::predictor::{InitialState, Levels};
use identification::{Direction, Excitation, MeanRemoval, Outcome};
use vessel::Vessel;

use super::Estimator;
use super::refined::refine;
use super::simulated::{Begin, simulated};
use crate::cli::name_of;
use crate::estimates::{Row, Status};
use crate::failure::Failure;
use crate::instruments::{InstrumentKind, Instruments};
use crate::pooled::{CollinearRun, collinear_run};
use crate::trajectories::Run;

/// Estimates runs one by one, each by every estimator that is asked for.
pub struct RunEstimators<'a> {
    /// The vessel.
    pub vessel: &'a Vessel,
    /// Its file, for messages.
    pub vessel_file: &'a Path,
    /// The trajectories' file, for messages.
    pub file: &'a Path,
    /// In the order of the rows.
    pub estimators: Vec<Estimator>,
    /// How the instruments' mean is removed.
    pub removal: MeanRemoval,
    /// Where simulations start.
    pub initial: InitialState,
    /// What disturbs the runs, as far as it is stated.
    pub levels: Option<Levels>,
}

/// An estimate of one run, and how it was excited.
#[derive(Clone)]
pub(super) struct Found {
    pub status: Status,
    pub estimate: Option<(Vec<f64>, Vec<f64>)>,
}

/// What instrumental variables, or least squares, make of one run.
#[derive(Clone)]
pub(super) struct Regressed {
    pub found: Found,
    condition: [f64; 3],
    weakest: [usize; 3],
}

impl RunEstimators<'_> {
    /// One row per run and estimator.
    ///
    /// # Errors
    /// A nominal simulation that diverges, a run that is too short.
    pub fn rows(&self, runs: &[Run]) -> Result<Vec<Row>, Failure> {
        let iv = match self.estimators.as_slice() {
            [Estimator::Ls] => Vec::new(),
            _ => self.regressed(InstrumentKind::Nominal, runs)?,
        };
        let mut columns = Vec::with_capacity(self.estimators.len());
        for estimator in &self.estimators {
            columns.push(self.column(*estimator, runs, &iv)?.into_iter());
        }
        Ok(runs.iter().flat_map(|_| columns.iter_mut().filter_map(Iterator::next).collect::<Vec<_>>()).collect())
    }

    fn column(
        &self,
        estimator: Estimator,
        runs: &[Run],
        iv: &[Regressed],
    ) -> Result<Vec<Row>, Failure> {
        let begin = Begin { vessel: self.vessel, initial: self.initial, levels: self.levels.as_ref() };
        let row = |((found, regressed), run): ((&Found, &Regressed), &Run)| {
            self.row(estimator, run, found, regressed)
        };
        let plain = |all: &[Regressed]| {
            all.iter().map(|r| (&r.found, r)).zip(runs).map(row).collect::<Vec<_>>()
        };
        let found: Vec<Found> = match estimator {
            Estimator::Ls => return Ok(plain(&self.regressed(InstrumentKind::Regressors, runs)?)),
            Estimator::Iv | Estimator::Auto => return Ok(plain(iv)),
            Estimator::RefinedIv => refine(self.vessel, runs, iv, self.removal),
            Estimator::OutputError => simulated(&begin, runs, iv, false),
            Estimator::PredictionError => simulated(&begin, runs, iv, true),
        };
        Ok(found.iter().zip(iv).zip(runs).map(row).collect())
    }

    fn regressed(&self, kind: InstrumentKind, runs: &[Run]) -> Result<Vec<Regressed>, Failure> {
        let mut all = Vec::with_capacity(runs.len());
        let instruments = Instruments::new(self.vessel, self.vessel_file, kind);
        instruments.estimates(runs, self.removal, |run, outcome, excitation| {
            let found = Regressed::new(outcome, excitation).ok_or_else(|| self.too_short(run))?;
            all.push(found);
            Ok(())
        })?;
        Ok(all)
    }

    fn too_short(&self, run: &Run) -> Failure {
        Failure::refuse(
            self.file,
            &format!("design {}, run {}", run.design, run.run),
            &format!("{} samples", run.samples()),
            "more samples than unknowns (parameters and intercepts of a degree of freedom)",
            "lengthen the run, or remove the mean over the whole run",
        )
    }

    /// What a measured run's instruments cannot tell apart; for estimators that need instruments. Others project or simulate
    /// whatever the columns.
    pub fn collinear(&self, run: &Run) -> Option<CollinearRun> {
        let instrumented = |e: &Estimator| matches!(e, Estimator::Iv | Estimator::RefinedIv);
        self.estimators.iter().any(instrumented).then(|| collinear_run(self.vessel, run, self.removal)).flatten()
    }

    fn row(&self, estimator: Estimator, run: &Run, found: &Found, excited: &Regressed) -> Row {
        let collinear = match estimator {
            Estimator::Iv | Estimator::RefinedIv => self.collinear(run),
            _ => None,
        };
        if let Some(at) = collinear {
            let mut excited = excited.clone();
            excited.weakest[at.degree] = at.parameter;
            excited.condition[at.degree] = f64::INFINITY;
            let none = Found { status: Status::NotIdentifiable, estimate: None };
            return self.as_row(estimator, run, &none, &excited);
        }
        self.as_row(estimator, run, found, excited)
    }

    fn as_row(&self, estimator: Estimator, run: &Run, found: &Found, excited: &Regressed) -> Row {
        let named = |d: usize| self.vessel.model.degrees[d].parameters[excited.weakest[d]].clone();
        Row {
            design: run.design.clone(),
            run: run.run,
            estimator: name_of(estimator),
            status: found.status,
            estimate: found.estimate.clone(),
            condition: excited.condition,
            weakest: [0, 1, 2].map(named),
        }
    }
}

impl Regressed {
    /// `None` for a run that is too short.
    pub(super) fn new(outcome: Outcome, excitation: [Excitation; 3]) -> Option<Self> {
        let mut weakest = [0, 1, 2].map(|d: usize| excitation[d].weakest);
        let mut condition = excitation.map(|e| e.condition);
        let found = match outcome {
            Outcome::Identified(found) => {
                Found { status: Status::Identified, estimate: Some((found.parameters, found.standard_errors)) }
            }
            Outcome::NotIdentifiable(Direction { degree, parameter }) => {
                weakest[degree] = parameter;
                condition[degree] = f64::INFINITY;
                Found { status: Status::NotIdentifiable, estimate: None }
            }
            Outcome::TooShort => return None,
        };
        Some(Self { found, condition, weakest })
    }

    /// θ̂, where there is one.
    pub(super) fn theta(&self) -> Option<&[f64]> {
        self.found.estimate.as_ref().map(|(theta, _)| theta.as_slice())
    }
}
