//! Estimates of single runs, by every estimator.

mod forces;
mod outcome;
mod searched;

use regression::pooled::{PartView, Regression};
use regression::runs::{CollinearRun, RunInstruments, collinear_run};
use regression::{InstrumentKind, MeanRemoval};
use ship::engine::{Run, RunView};
use ship::model::{Model, Vessel};

use crate::criticism::{Subject, criticise_each};
use crate::pooled::{Delivered, Surroundings};
use crate::predictor::{InitialState, NoiseModel};
use crate::{EstimateCovariance, EstimateStatus, Estimator, RunEstimate};
use outcome::{Regressed, RunOutcome, refined};

pub use crate::estimator::{AdditionalUnknowns, Intercepts, UnknownCurrent};
pub use forces::Unsuited;
pub use outcome::RunError;

/// Estimates runs one by one, each by every requested estimator.
pub struct RunEstimators<'a> {
    /// The vessel.
    pub vessel: &'a Vessel,
    /// In the order of the estimates.
    pub estimators: Vec<Estimator>,
    /// How the instruments' mean is removed.
    pub removal: MeanRemoval,
    /// The start of simulations.
    pub initial: InitialState,
    /// Additional unknowns of searches.
    pub additional: AdditionalUnknowns,
    /// The disturbances of the runs, if stated.
    pub levels: Option<NoiseModel>,
}

/// Parameters near those of a run, if known.
type Near = Option<Vec<f64>>;

#[derive(Default)]
struct EstimatorResults {
    ls: Vec<Regressed>,
    iv: Vec<Regressed>,
    simulated: Vec<RunOutcome>,
    predicted: Vec<RunOutcome>,
}

impl EstimatorResults {
    /// The results of one estimator, run by run, and the excitation of the runs.
    fn by(&self, estimator: Estimator) -> (Vec<&RunOutcome>, &[Regressed]) {
        match estimator {
            Estimator::Ls => (self.ls.iter().map(|run| &run.outcome).collect(), &self.ls),
            Estimator::Iv | Estimator::Auto => (self.iv.iter().map(|run| &run.outcome).collect(), &self.iv),
            Estimator::OutputError => (self.simulated.iter().collect(), &self.iv),
            Estimator::PredictionError => (self.predicted.iter().collect(), &self.iv),
        }
    }

    fn rows<'f>(
        &'f self,
        all: &RunEstimators,
        estimator: Estimator,
        runs: &[Run],
    ) -> Vec<(RunEstimate, Option<&'f [f64]>)> {
        let (outcomes, excited) = self.by(estimator);
        let row = |((outcome, excited), run): ((&'f RunOutcome, &Regressed), &Run)| {
            let row = all.row(estimator, run, outcome, excited);
            let covariance = outcome.covariance.as_deref().filter(|_| row.estimate.is_some());
            (row, covariance)
        };
        outcomes.into_iter().zip(excited).zip(runs).map(row).collect()
    }
}

impl RunEstimators<'_> {
    /// One estimate per run and estimator, run by run.
    ///
    /// # Errors
    /// A diverging nominal simulation, a run that is too short.
    pub fn estimates(&self, runs: &[Run]) -> Result<Vec<RunEstimate>, RunError> {
        self.estimates_from(runs, None)
    }

    /// The same, with searches from the estimates `near`, if known, by run.
    ///
    /// # Errors
    /// See [`RunEstimators::estimates`].
    pub fn estimates_from(&self, runs: &[Run], near: Option<&[Near]>) -> Result<Vec<RunEstimate>, RunError> {
        Ok(self.each(runs, near)?.into_iter().map(|(row, _)| row).collect())
    }

    /// The same, each with its covariance.
    ///
    /// # Errors
    /// See [`RunEstimators::estimates`].
    pub fn estimates_with_covariances(
        &self,
        runs: &[Run],
    ) -> Result<Vec<(RunEstimate, EstimateCovariance)>, RunError> {
        self.each(runs, None)
    }

    fn each(
        &self,
        runs: &[Run],
        near: Option<&[Near]>,
    ) -> Result<Vec<(RunEstimate, EstimateCovariance)>, RunError> {
        if let Some(moved) = &self.vessel.model.forces {
            return self.by_forces(moved, runs);
        }
        let results = self.results(runs, near)?;
        let rows = self.rows(&results, runs).into_iter();
        Ok(rows.map(|(row, covariance)| (row, covariance.map(<[f64]>::to_vec))).collect())
    }

    fn rows<'f>(&self, results: &'f EstimatorResults, runs: &[Run]) -> Vec<(RunEstimate, Option<&'f [f64]>)> {
        let columns = self.estimators.iter().map(|e| results.rows(self, *e, runs).into_iter());
        let mut columns: Vec<_> = columns.collect();
        let row = |_| columns.iter_mut().filter_map(Iterator::next).collect::<Vec<_>>();
        runs.iter().flat_map(row).collect()
    }

    /// The model of the first estimator from `run`, which is called `name`, with that by least squares; `None`
    /// without an estimate, and of a ship with forces, whose model `estimate --fit together` delivers.
    ///
    /// # Errors
    /// See [`RunEstimators::estimates`].
    pub fn delivered(&self, run: &Run, name: &str) -> Result<Option<(RunEstimate, Delivered)>, RunError> {
        let (runs, model) = (std::slice::from_ref(run), &self.vessel.model);
        let Some(estimator) = self.estimators.first().copied().filter(|_| model.has_regressors()) else {
            return Ok(None);
        };
        let results = self.results(runs, None)?;
        let (intercepts, current) = results
            .by(estimator)
            .0
            .first()
            .map_or((None, None), |outcome| (outcome.intercepts, outcome.current));
        let surroundings = current.map(|current| Surroundings::of((name, 0), current));
        let row = results.rows(self, estimator, runs).pop().map(|(row, _)| row);
        let Some((row, theta)) = row.and_then(|row| Some((row.clone(), row.estimate?.0))) else {
            return Ok(None);
        };
        let simple = self.regressed(InstrumentKind::Regressors, runs)?;
        let simple = simple.first().and_then(|regressed| regressed.outcome.theta()).map(<[f64]>::to_vec);
        let whole = RunView::measured(&run.measured, &run.exogenous);
        let part = PartView { label: "", source: name, run: whole };
        let left = |theta: &[f64]| match self.removal {
            MeanRemoval::None => [0.0; 3],
            _ => Regression::of(model, &part).left(theta),
        };
        let simple = simple.map(|theta| {
            let intercepts = left(&theta);
            (theta, intercepts)
        });
        let intercepts = intercepts.unwrap_or_else(|| left(&theta));
        Ok(Some((row, Delivered::of_run(model, &part, (theta, intercepts), simple, surroundings))))
    }

    /// Everything that the requested estimators need, each computed once; searches begin at `near`, if known.
    fn results(&self, runs: &[Run], near: Option<&[Near]>) -> Result<EstimatorResults, RunError> {
        use Estimator::{Ls, OutputError, PredictionError};
        let wanted = |any: &[Estimator]| self.estimators.iter().any(|e| any.contains(e));
        let mut results = EstimatorResults::default();
        if wanted(&[Ls]) {
            results.ls = self.regressed(InstrumentKind::Regressors, runs)?;
        }
        if self.estimators.iter().any(|e| *e != Ls) {
            results.iv = self.instrumented(runs)?;
        }
        if wanted(&[OutputError, PredictionError]) {
            let levels = self.levels.as_ref();
            let near = match near {
                Some(near) => {
                    let or_iv = |(near, iv): (&Option<Vec<f64>>, &Regressed)| {
                        near.as_deref().or(iv.outcome.theta()).map(<[f64]>::to_vec)
                    };
                    near.iter().zip(&results.iv).map(or_iv).collect()
                }
                None => refined(self.vessel, runs, &results.iv, self.removal, levels),
            };
            let free = self.output_error(runs, &near, &results.iv, wanted(&[OutputError]));
            results.simulated = free.iter().map(RunOutcome::from).collect();
            if wanted(&[PredictionError]) {
                let fits = match levels {
                    Some(levels) => self.prediction_error(runs, &free, &near, levels),
                    None => self.calibrated(runs, &free, &near),
                };
                results.predicted = fits.iter().map(RunOutcome::from).collect();
            }
        }
        Ok(results)
    }

    fn regressed(&self, kind: InstrumentKind, runs: &[Run]) -> Result<Vec<Regressed>, RunError> {
        let outcomes = RunInstruments::new(self.vessel, kind).estimates(runs, self.removal)?;
        let each = runs.iter().zip(outcomes);
        each.map(|(run, (outcome, excitation))| Regressed::new(run, outcome, excitation)).collect()
    }

    /// Terms that a run's instruments cannot distinguish; only for estimators that need instruments.
    pub fn collinear(&self, run: &Run) -> Option<CollinearRun> {
        let instrumented = self.estimators.iter().any(|e| e.by_instruments());
        instrumented.then(|| collinear_run(self.vessel, run, self.removal)).flatten()
    }

    fn row(&self, estimator: Estimator, run: &Run, outcome: &RunOutcome, excited: &Regressed) -> RunEstimate {
        let collinear = estimator.by_instruments().then(|| self.collinear(run)).flatten();
        match collinear {
            Some(at) => {
                let none = excited.clone().unidentified(at.degree, at.parameter);
                none.estimate(self.vessel, run, estimator, &none.outcome)
            }
            None => excited.estimate(self.vessel, run, estimator, outcome),
        }
    }
}

impl RunEstimators<'_> {
    /// Whether runs are tested: those whose disturbances are stated, but of no ship with forces. The noise of a sensor is never
    /// exactly zero.
    pub fn asks(&self) -> bool {
        let stated = self.levels.is_some_and(|levels| levels.measurement.iter().all(|std| *std > 0.0));
        stated && self.vessel.model.has_regressors()
    }

    /// Seconds of a test per row and thread, order of magnitude; see [`crate::Estimator::seconds_per_row`].
    pub const SECONDS_PER_ROW_ASKED: f64 = 6e-6;

    /// Tests on every run by itself what the model lacks; the estimates of runs that reject it are marked. Estimates
    /// are first refined under the noise, so that the verdict depends on model and run, not on the estimator, and one
    /// is enough for all of them. `estimates`: those of `runs`, as [`RunEstimators::estimates`] orders them.
    pub fn criticise(&self, runs: &[Run], estimates: &mut [RunEstimate]) {
        let each = self.estimators.len().max(1);
        let (layout, model) =
            (self.vessel.model.layout().with_intercepts(), self.vessel.model.with_intercepts());
        // The last estimator with an estimate: those that simulate come after those that regress.
        let theta_of = |rows: &[RunEstimate]| {
            rows.iter().rev().find_map(|e| e.estimate.as_ref().map(|(theta, _)| theta.clone()))
        };
        // Runs whose estimates are held at the same bounds, if at any, are tested together.
        let mut alike: Vec<(Model, Vec<usize>, Vec<Vec<f64>>)> = Vec::new();
        for (run, rows) in estimates.chunks(each).enumerate() {
            let Some(theta) = theta_of(rows) else { continue };
            let (held, theta) = model.held_at_bounds(&layout.woven(&theta, [0.0; 3]));
            match alike.iter_mut().find(|(model, ..)| *model == held) {
                Some((_, runs, thetas)) => {
                    runs.push(run);
                    thetas.push(theta);
                }
                None => alike.push((held, vec![run], vec![theta])),
            }
        }
        for (model, asked, thetas) in &alike {
            let views: Vec<RunView> = asked.iter().map(|run| runs[*run].view()).collect();
            let subject = Subject {
                model,
                runs: &views,
                rate_hz: self.vessel.sample_rate_hz,
                known_start: self.initial == InitialState::Known,
                levels: self.levels,
                names: &[],
                signs: &[],
            };
            for (run, criticism) in asked.iter().zip(criticise_each(&subject, thetas)) {
                let rejected = criticism.is_some_and(|tests| tests.rejected);
                let rows = &mut estimates[run * each..(run + 1) * each];
                for row in rows.iter_mut().filter(|row| rejected && row.estimate.is_some()) {
                    row.status = EstimateStatus::Rejected;
                }
            }
        }
    }
}
