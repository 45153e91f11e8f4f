//! Output error and prediction error of single runs.

use std::borrow::Cow;
use std::slice;

use numerics::Lane;
use rayon::prelude::*;
use regression::runs::Prepared;
use regression::{InstrumentKind, Instruments};
use ship::engine::{Run, RunView};
use ship::model::Model;

use super::outcome::{Regressed, RunError};
use super::{Near, RunEstimators};
use crate::EstimateStatus;
use crate::criticism::{Calibrated, calibrated};
use crate::estimator::Intercepts;
use crate::predictor::{
    Fitted, FoundSpread, InitialState, NoiseModel, RunFit, Spread, Unknown, errors_by_blocks, held, of_terms,
    output_error, prediction_error, roots, scaled,
};

impl RunEstimators<'_> {
    /// Minimises the errors of free simulations, from `near`, `iv` or the nominal model. Without errors no noise is
    /// needed.
    pub(super) fn output_error(
        &self,
        runs: &[Run],
        near: &[Near],
        iv: &[Regressed],
        errors: bool,
    ) -> Vec<RunFit> {
        let starts = |(near, iv): (&Near, &Regressed)| {
            self.starts([near.as_deref(), iv.outcome.theta()].map(|theta| theta.map(without)))
        };
        let starts: Vec<Vec<Vec<f64>>> = near.iter().zip(iv).map(starts).collect();
        let (model, views) = (self.lifted(), views(runs));
        let of = |run: usize, theta: &[f64]| {
            let noise = self.noise(&model, views[run], &[theta.to_vec()]);
            let waves = noise.as_ref().is_some_and(|noise| noise.waves);
            let spread_of =
                |noise: Calibrated| FoundSpread { levels: noise.near, factor: noise.factor, waves };
            let blocks = FoundSpread { levels: Vec::new(), factor: 1.0, waves };
            noise.filter(|noise| noise.white).map_or(blocks, spread_of)
        };
        let spread = match &self.levels {
            Some(levels) => Spread::Stated(levels),
            None if errors => Spread::Found(&of),
            None => Spread::Blocks,
        };
        output_error(&model, &views, &starts, self.unknown(), spread)
    }

    pub(super) fn unknown(&self) -> Unknown {
        Unknown::new(self.initial, self.additional, 1.0 / self.vessel.sample_rate_hz)
    }

    /// Minimises the errors of predictions of `runs` by a filter for `levels`, from the minima of free simulations.
    pub(super) fn prediction_error(
        &self,
        runs: &[Run],
        free: &[RunFit],
        near: &[Near],
        levels: &NoiseModel,
    ) -> Vec<RunFit> {
        let starts = |(free, near): (&RunFit, &Near)| {
            self.starts([converged(free).map(with_intercepts), near.as_deref().map(without)])
        };
        let starts: Vec<Vec<Vec<f64>>> = free.iter().zip(near).map(starts).collect();
        prediction_error(&self.lifted(), &views(runs), &starts, self.initial, levels)
    }

    /// Seconds of the search for noise per row and thread; see [`crate::Estimator::seconds_per_row`].
    pub fn seconds_per_row_calibrated(&self) -> f64 {
        let searched = self.estimators.iter().filter(|estimator| estimator.searches()).count();
        if self.levels.is_none() { 1e-3 * searched as f64 } else { 0.0 }
    }

    /// The same without stated noise: it is found by the likelihood of each run by itself, alternately with its
    /// parameters, from the minimum of free simulations, else from the estimates `near` or the nominal model.
    pub(super) fn calibrated(&self, runs: &[Run], free: &[RunFit], near: &[Near]) -> Vec<RunFit> {
        let each = runs.par_iter().zip(free).zip(near);
        each.map(|((run, free), near)| self.calibrated_to(run, free, near)).collect()
    }

    fn calibrated_to(&self, run: &Run, free: &RunFit, near: &Near) -> RunFit {
        let (model, view) = (self.lifted(), run.view());
        let starts = self.starts([converged(free).map(with_intercepts), near.as_deref().map(without)]);
        // An estimate by simulations is a different one: it does not replace a failed estimate by a filter.
        let none = || match free {
            RunFit::NotIdentifiable(_) => free.clone(),
            RunFit::Converged(fitted) => RunFit::NotConverged(fitted.steps),
            RunFit::NotConverged(steps) => RunFit::NotConverged(*steps),
        };
        let Some(noise) = self.noise(&model, view, &starts) else { return none() };
        let starts = [vec![noise.parameters.clone()]];
        let fit = prediction_error(&model, &[view], &starts, self.initial, &noise.levels).pop();
        match fit {
            Some(RunFit::Converged(fitted)) => {
                RunFit::Converged(self.with_errors_of(fitted, &model, view, &noise))
            }
            other => other.unwrap_or_else(none),
        }
    }

    /// The noise of a run, found alternately with its parameters from the first of `starts` that succeeds.
    fn noise(&self, model: &Model, run: RunView, starts: &[Vec<f64>]) -> Option<Calibrated> {
        let known = self.initial == InitialState::Known;
        calibrated(model, &[run], self.vessel.sample_rate_hz, known, starts)
    }

    /// An estimate with errors under the noise that was found, or approximate ones if errors follow no known noise.
    fn with_errors_of(&self, fitted: Fitted, model: &Model, run: RunView, noise: &Calibrated) -> Fitted {
        let layout = model.layout();
        let theta = layout.woven(&fitted.parameters, fitted.intercepts);
        let found_ones = || (fitted.standard_errors.clone(), fitted.covariance.clone());
        let (widths, covariance) = if noise.waves {
            (vec![f64::NAN; fitted.standard_errors.len()], None)
        } else if noise.white {
            let widest = noise.widest.as_ref().map(|errors| (layout.theta(errors), None));
            let (all, covariance) = widest.unwrap_or_else(found_ones);
            let all = all.into_iter().map(|error| noise.factor * error).collect();
            (all, covariance.map(|covariance| scaled(covariance, noise.factor)))
        } else {
            let blocks = errors_by_blocks(model, run, &theta, self.initial, &noise.levels);
            let of_blocks = blocks
                .map(|covariance| of_terms(layout, &covariance))
                .map(|of_terms_only| (roots(&of_terms_only), Some(of_terms_only)));
            of_blocks.unwrap_or_else(found_ones)
        };
        // A parameter at a bound has no error.
        let zero = |(before, error): (&f64, f64)| if *before == 0.0 { 0.0 } else { error };
        let covariance = covariance.map(|covariance| held(covariance, &fitted.standard_errors));
        let standard_errors = fitted.standard_errors.iter().zip(widths).map(zero).collect();
        Fitted { standard_errors, covariance, approximate: !noise.white, ..fitted }
    }

    fn lifted(&self) -> Cow<'_, Model> {
        match self.additional.intercepts {
            Intercepts::Each => Cow::Owned(self.vessel.model.with_intercepts()),
            Intercepts::None => Cow::Borrowed(&self.vessel.model),
        }
    }

    fn starts(&self, known: [Option<Start>; 2]) -> Vec<Vec<f64>> {
        let layout = self.lifted().layout();
        let all = known.into_iter().flatten().chain([without(&self.vessel.nominal)]);
        all.map(|(theta, intercepts)| layout.woven(theta, intercepts)).collect()
    }
}

/// Parameters of the terms, and intercepts.
type Start<'a> = (&'a [f64], [f64; 3]);

fn converged(fit: &RunFit) -> Option<&Fitted> {
    match fit {
        RunFit::Converged(fitted) => Some(fitted),
        _ => None,
    }
}

fn with_intercepts(fitted: &Fitted) -> Start<'_> {
    (&fitted.parameters, fitted.intercepts)
}

fn without(theta: &[f64]) -> Start<'_> {
    (theta, [0.0; 3])
}

fn views(runs: &[Run]) -> Vec<RunView<'_>> {
    runs.iter().map(Run::view).collect()
}

impl RunEstimators<'_> {
    /// Estimates by instruments of the nominal model. Where it diverges, they are those of the model of least output
    /// error: to first order its errors are means over the run, so that its states know little of the noise at one
    /// sample.
    pub(super) fn instrumented(&self, runs: &[Run]) -> Result<Vec<Regressed>, RunError> {
        match self.regressed(InstrumentKind::Nominal, runs) {
            Err(RunError::Diverged(_)) => runs.iter().map(|run| self.instrumented_alone(run)).collect(),
            all => all,
        }
    }

    fn instrumented_alone(&self, run: &Run) -> Result<Regressed, RunError> {
        let one = slice::from_ref(run);
        let diverged = match self.regressed(InstrumentKind::Nominal, one) {
            Err(RunError::Diverged(at)) => RunError::Diverged(at),
            other => return other.map(|mut regressed| regressed.remove(0)),
        };
        let simple = self.regressed(InstrumentKind::Regressors, one)?.remove(0);
        let Some(start) = simple.outcome.theta() else { return Err(diverged) };
        let instrumented =
            match self.output_error(one, &[Some(start.to_vec())], slice::from_ref(&simple), false).pop() {
                Some(RunFit::Converged(fitted)) => self.instrumented_by(run, &fitted.parameters)?,
                _ => None,
            };
        Ok(instrumented.unwrap_or_else(|| simple.without(EstimateStatus::NotConverged)))
    }

    /// The estimate of `run` with instruments simulated by the parameters `theta`; `None` where these diverge.
    fn instrumented_by(&self, run: &Run, theta: &[f64]) -> Result<Option<Regressed>, RunError> {
        let mut prepared = Prepared::regressed(self.vessel, slice::from_ref(run));
        prepared.simulate(&theta.iter().copied().map(Lane::splat).collect::<Vec<_>>());
        if prepared.diverged(0).is_some() {
            return Ok(None);
        }
        let batch = prepared.batch();
        let (outcome, excitation) =
            Instruments::new(&batch, self.removal).estimate_with_excitation(&batch).swap_remove(0);
        let mut regressed = Regressed::new(run, outcome, excitation)?;
        if regressed.outcome.status == EstimateStatus::Identified {
            regressed.outcome.status = EstimateStatus::OwnInstruments;
        }
        Ok(Some(regressed))
    }
}
