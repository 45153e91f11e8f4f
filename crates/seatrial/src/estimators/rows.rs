use std::path::Path;

use identification::predictor::{InitialState, Levels};
use identification::{Direction, Excitation, MeanRemoval, Outcome};
use vessel::Vessel;

use super::Estimator;
use super::refined::refine;
use super::simulated::Begin;
use crate::failure::Failure;
use crate::instruments::{InstrumentKind, Instruments};
use crate::pooled::{CollinearRun, collinear_run};
use identification::EstimateStatus as Status;
use study::estimates::Row;
use vessel::Run;

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

impl Found {
    /// θ̂, where there is one.
    pub(super) fn theta(&self) -> Option<&[f64]> {
        self.estimate.as_ref().map(|(theta, _)| theta.as_slice())
    }
}

/// What instrumental variables, or least squares, make of one run.
#[derive(Clone)]
pub(super) struct Regressed {
    pub found: Found,
    condition: [f64; 3],
    weakest: [usize; 3],
}

/// What the estimators make of some runs; empty for those that nothing asks for.
#[derive(Default)]
struct Everything {
    ls: Vec<Regressed>,
    iv: Vec<Regressed>,
    refined: Vec<Found>,
    simulated: Vec<Found>,
    predicted: Vec<Found>,
}

impl Everything {
    /// The rows of one estimator.
    fn column(&self, all: &RunEstimators, estimator: Estimator, runs: &[Run]) -> Vec<Row> {
        let rows = |found: &mut dyn Iterator<Item = &Found>, excited: &[Regressed]| {
            let each = found.zip(excited).zip(runs);
            each.map(|((found, excited), run)| all.row(estimator, run, found, excited)).collect()
        };
        match estimator {
            Estimator::Ls => rows(&mut self.ls.iter().map(|r| &r.found), &self.ls),
            Estimator::Iv | Estimator::Auto => rows(&mut self.iv.iter().map(|r| &r.found), &self.iv),
            Estimator::RefinedIv => rows(&mut self.refined.iter(), &self.iv),
            Estimator::OutputError => rows(&mut self.simulated.iter(), &self.iv),
            Estimator::PredictionError => rows(&mut self.predicted.iter(), &self.iv),
        }
    }
}

impl RunEstimators<'_> {
    /// One row per run and estimator.
    ///
    /// # Errors
    /// A nominal simulation that diverges, a run that is too short.
    pub fn rows(&self, runs: &[Run]) -> Result<Vec<Row>, Failure> {
        let found = self.found(runs)?;
        let columns: Vec<Vec<Row>> = self.estimators.iter().map(|e| found.column(self, *e, runs)).collect();
        let mut columns: Vec<_> = columns.into_iter().map(Vec::into_iter).collect();
        let row = |_| columns.iter_mut().filter_map(Iterator::next).collect::<Vec<_>>();
        Ok(runs.iter().flat_map(row).collect())
    }

    /// Everything that the wanted estimators need, each made once.
    fn found(&self, runs: &[Run]) -> Result<Everything, Failure> {
        use Estimator::{Ls, OutputError, PredictionError, RefinedIv};
        let wanted = |any: &[Estimator]| self.estimators.iter().any(|e| any.contains(e));
        let mut found = Everything::default();
        if wanted(&[Ls]) {
            found.ls = self.regressed(InstrumentKind::Regressors, runs)?;
        }
        if self.estimators.iter().any(|e| *e != Ls) {
            found.iv = self.regressed(InstrumentKind::Nominal, runs)?;
        }
        if wanted(&[RefinedIv, OutputError, PredictionError]) {
            found.refined = refine(self.vessel, runs, &found.iv, self.removal, self.levels.as_ref());
        }
        let begin = Begin { vessel: self.vessel, initial: self.initial, levels: self.levels.as_ref() };
        if wanted(&[OutputError, PredictionError]) {
            let iv: Vec<Found> = found.iv.iter().map(|r| r.found.clone()).collect();
            let free = begin.output_error(runs, &found.refined, &iv);
            found.simulated = free.iter().map(Found::from).collect();
            if let Some(levels) = self.levels.as_ref().filter(|_| wanted(&[PredictionError])) {
                let fits = begin.prediction_error(runs, &free, &found.refined, levels);
                found.predicted = fits.iter().map(Found::from).collect();
            }
        }
        Ok(found)
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
        self.estimators
            .iter()
            .any(instrumented)
            .then(|| collinear_run(self.vessel, run, self.removal))
            .flatten()
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
            estimator,
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
            Outcome::Identified(found) => Found {
                status: Status::Identified,
                estimate: Some((found.parameters, found.standard_errors)),
            },
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
        self.found.theta()
    }
}
