//! Output error and prediction error of single runs.

use identification::predictor::{
    Fit, InitialState, Levels, Recording, Spread, output_error, prediction_error,
};
use vessel::Vessel;

use super::rows::Found;
use identification::EstimateStatus as Status;
use vessel::Run;

/// What all runs have in common.
pub(super) struct Begin<'a> {
    pub vessel: &'a Vessel,
    pub initial: InitialState,
    pub levels: Option<&'a Levels>,
}

impl Begin<'_> {
    /// Least errors of free simulations of `runs`. Searches begin at the estimates `near`, then at those of `iv`, then at the
    /// nominal model, where there is none or it leads nowhere.
    pub(super) fn output_error(&self, runs: &[Run], near: &[Found], iv: &[Found]) -> Vec<Fit> {
        let starts = |(near, iv): (&Found, &Found)| self.starts([near.theta(), iv.theta()]);
        let starts: Vec<Vec<Vec<f64>>> = near.iter().zip(iv).map(starts).collect();
        let spread = self.levels.map_or(Spread::Residuals, Spread::Stated);
        output_error(&self.vessel.model, &recordings(runs), &starts, self.initial, spread)
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
            let lifted = match free {
                Fit::Converged(found) => Some([&found.parameters[..], &found.intercepts].concat()),
                _ => None,
            };
            self.starts([lifted.as_deref(), near.theta()])
        };
        let starts: Vec<Vec<Vec<f64>>> = free.iter().zip(near).map(starts).collect();
        prediction_error(&self.vessel.model, &recordings(runs), &starts, self.initial, levels)
    }

    /// Those of `known` that there are, and the nominal model.
    fn starts(&self, known: [Option<&[f64]>; 2]) -> Vec<Vec<f64>> {
        known.into_iter().flatten().chain([self.vessel.nominal.as_slice()]).map(<[f64]>::to_vec).collect()
    }
}

fn recordings(runs: &[Run]) -> Vec<Recording<'_>> {
    runs.iter()
        .map(|run| Recording { measured: &run.measured, exogenous: &run.exogenous, initial: run.initial })
        .collect()
}

impl From<&Fit> for Found {
    fn from(fit: &Fit) -> Self {
        match fit {
            Fit::Converged(found) => Self {
                status: Status::Identified,
                estimate: Some((found.parameters.clone(), found.standard_errors.clone())),
            },
            Fit::NotConverged(_) => Self { status: Status::NotConverged, estimate: None },
            Fit::NotIdentifiable(_) => Self { status: Status::NotIdentifiable, estimate: None },
        }
    }
}
