//! Output error and prediction error of single runs.

use std::borrow::Cow;

use vessel::{Model, Run, RunView};

use super::beside::{Intercepts, UnknownCurrent};
use super::estimators::RunEstimators;
use super::found::Found;
use crate::predictor::{Fit, Levels, Spread, Unknown, output_error, prediction_error};

impl RunEstimators<'_> {
    /// Least errors of free simulations of `runs`. Searches begin at the estimates `near`, then at those of `iv`, then at the
    /// nominal model, where there is none or it leads nowhere.
    pub(super) fn output_error(&self, runs: &[Run], near: &[Found], iv: &[Found]) -> Vec<Fit> {
        let starts =
            |(near, iv): (&Found, &Found)| self.starts([near, iv].map(|found| found.theta().map(without)));
        let starts: Vec<Vec<Vec<f64>>> = near.iter().zip(iv).map(starts).collect();
        let spread = self.levels.as_ref().map_or(Spread::Residuals, Spread::Stated);
        let current = match self.beside.current {
            UnknownCurrent::None => None,
            UnknownCurrent::Earth => Some(1.0 / self.vessel.sample_rate_hz),
            UnknownCurrent::Body => Some(0.0),
        };
        let unknown = Unknown { initial: self.initial, current };
        output_error(&self.lifted(), &views(runs), &starts, unknown, spread)
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
            let free = match free {
                Fit::Converged(found) => Some((&found.parameters[..], found.intercepts)),
                _ => None,
            };
            self.starts([free, near.theta().map(without)])
        };
        let starts: Vec<Vec<Vec<f64>>> = free.iter().zip(near).map(starts).collect();
        prediction_error(&self.lifted(), &views(runs), &starts, self.initial, levels)
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

fn without(theta: &[f64]) -> Start<'_> {
    (theta, [0.0; 3])
}

fn views(runs: &[Run]) -> Vec<RunView<'_>> {
    runs.iter().map(Run::view).collect()
}
