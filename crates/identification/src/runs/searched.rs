//! Output error and prediction error of single runs.

use std::borrow::Cow;
use std::convert::Infallible;

use rayon::prelude::*;
use vessel::{Model, Run, RunView};

use super::estimators::RunEstimators;
use super::found::Found;
use crate::Estimator;
use crate::beside::Intercepts;
use crate::criticism::Calibration;
use crate::predictor::{
    Fit, Fitted, InitialState, Levels, Spread, Unknown, mean_square, output_error, prediction_error,
};

/// Share of the motion that errors are first thought to have where no free simulation follows it.
const UNKNOWN: f64 = 0.2;

impl RunEstimators<'_> {
    /// Least errors of free simulations of `runs`. Searches begin at the estimates `near`, then at those of `iv`, then at the
    /// nominal model, where there is none or it leads nowhere.
    pub(super) fn output_error(&self, runs: &[Run], near: &[Found], iv: &[Found]) -> Vec<Fit> {
        let starts =
            |(near, iv): (&Found, &Found)| self.starts([near, iv].map(|found| found.theta().map(without)));
        let starts: Vec<Vec<Vec<f64>>> = near.iter().zip(iv).map(starts).collect();
        let spread = self.levels.as_ref().map_or(Spread::Residuals, Spread::Stated);
        output_error(&self.lifted(), &views(runs), &starts, self.unknown(), spread)
    }

    /// What free simulations do not know.
    pub(super) fn unknown(&self) -> Unknown {
        Unknown::new(self.initial, self.beside, 1.0 / self.vessel.sample_rate_hz)
    }

    /// Least errors of the predictions of `runs` by a filter for `levels`, from where free simulations have the least.
    pub(super) fn prediction_error(
        &self,
        runs: &[Run],
        free: &[Fit],
        near: &[Found],
        levels: &Levels,
    ) -> Vec<Fit> {
        let starts = |(free, near): (&Fit, &Found)| {
            self.starts([converged(free).map(with_intercepts), near.theta().map(without)])
        };
        let starts: Vec<Vec<Vec<f64>>> = free.iter().zip(near).map(starts).collect();
        prediction_error(&self.lifted(), &views(runs), &starts, self.initial, levels)
    }

    /// Seconds that finding out what disturbs runs takes a thread for a row, to the order; see [`crate::Estimator::seconds_per_row`].
    pub fn seconds_per_row_calibrated(&self) -> f64 {
        let wanted = self.estimators.contains(&Estimator::PredictionError);
        if wanted && self.levels.is_none() { 1e-3 } else { 0.0 }
    }

    /// The same where nobody says what disturbs `runs`: noise and a current are found by the likelihood of each run by itself, in
    /// turns with its parameters, from where free simulations have the least errors, from the estimates `near` and from the nominal
    /// model. The most likely of what they lead to counts.
    pub(super) fn calibrated(&self, runs: &[Run], free: &[Fit], near: &[Found]) -> Vec<Fit> {
        let each = runs.par_iter().zip(free).zip(near);
        each.map(|((run, free), near)| self.calibrated_to(run, free, near)).collect()
    }

    fn calibrated_to(&self, run: &Run, free: &Fit, near: &Found) -> Fit {
        let (model, view) = (self.lifted(), run.view());
        let layout = model.layout();
        let known = self.initial == InitialState::Known;
        let simulated = converged(free);
        let errors = simulated
            .map_or_else(|| [0, 1, 2].map(|d: usize| UNKNOWN * mean_square(&view, d).sqrt()), |own| own.rmse);
        let rate_hz = self.vessel.sample_rate_hz;
        let calibration = Calibration::new(&model, std::iter::once(view), rate_hz, known, errors);
        let fit = |levels: &Levels, theta: &[f64]| {
            let starts = [vec![theta.to_vec()]];
            let fit = prediction_error(&model, &[view], &starts, self.initial, levels).pop();
            let next = fit.as_ref().and_then(converged);
            let next = next.map(|found| layout.woven(&found.parameters, found.intercepts));
            Ok::<_, Infallible>(next.zip(fit))
        };
        let starts = self.starts([simulated.map(with_intercepts), near.theta().map(without)]);
        let turned = starts.into_iter().filter_map(|theta| {
            let Ok(turned) = calibration.in_turns(theta, fit);
            turned
        });
        let best = turned.reduce(|best, own| if own.0 > best.0 { own } else { best });
        best.map_or_else(|| free.clone(), |(_, fit)| fit)
    }

    /// The model with its intercepts, if it is to have any.
    fn lifted(&self) -> Cow<'_, Model> {
        match self.beside.intercepts {
            Intercepts::Each => Cow::Owned(self.vessel.model.with_intercepts()),
            Intercepts::None => Cow::Borrowed(&self.vessel.model),
        }
    }

    /// Those of `known` that there are, and the nominal model.
    fn starts(&self, known: [Option<Start>; 2]) -> Vec<Vec<f64>> {
        let layout = self.lifted().layout();
        let all = known.into_iter().flatten().chain([without(&self.vessel.nominal)]);
        all.map(|(theta, intercepts)| layout.woven(theta, intercepts)).collect()
    }
}

/// Parameters of the terms, and intercepts.
type Start<'a> = (&'a [f64], [f64; 3]);

fn converged(fit: &Fit) -> Option<&Fitted> {
    match fit {
        Fit::Converged(found) => Some(found),
        _ => None,
    }
}

fn with_intercepts(found: &Fitted) -> Start<'_> {
    (&found.parameters, found.intercepts)
}

fn without(theta: &[f64]) -> Start<'_> {
    (theta, [0.0; 3])
}

fn views(runs: &[Run]) -> Vec<RunView<'_>> {
    runs.iter().map(Run::view).collect()
}
