//! Output error and prediction error over batches of runs.

use identification::predictor::{
    Fit, InitialState, Levels, Recordings, Spread, output_error, prediction_error,
};
use vessel::{LANES, Lane, Vessel};

use super::rows::{Found, Regressed};
use crate::estimates::Status;
use crate::lanes::{groups, interleave};
use crate::trajectories::Run;

/// What all runs have in common.
pub(super) struct Begin<'a> {
    pub vessel: &'a Vessel,
    pub initial: InitialState,
    pub levels: Option<&'a Levels>,
}

/// Estimates `runs` by output error, or by prediction error started there. Searches begin at the instrumental-variable
/// estimates `iv`, or at the nominal model where there are none or they lead nowhere.
pub(super) fn simulated(begin: &Begin, runs: &[Run], iv: &[Regressed], predict: bool) -> Vec<Found> {
    let lengths: Vec<usize> = runs.iter().map(Run::samples).collect();
    let mut all = Vec::with_capacity(runs.len());
    for group in groups(&lengths) {
        let (members, own) = (&runs[group.clone()], &iv[group]);
        all.extend(begin.fits(members, own, predict).into_iter().take(members.len()).map(Found::from));
    }
    all
}

impl Begin<'_> {
    fn fits(&self, runs: &[Run], iv: &[Regressed], predict: bool) -> Vec<Fit> {
        let exogenous = interleave(&runs.iter().map(|r| r.exogenous.as_slice()).collect::<Vec<_>>());
        let measured = interleave(&runs.iter().map(|r| r.measured.as_slice()).collect::<Vec<_>>());
        let last = runs.len() - 1;
        let start = |d: usize| Lane(std::array::from_fn(|lane| runs[lane.min(last)].initial[d]));
        let recordings = Recordings {
            model: &self.vessel.model,
            measured: &measured,
            exogenous: &exogenous,
            initial: [0, 1, 2].map(start),
            samples: [runs[0].samples(); LANES],
        };
        let nominal = || self.vessel.nominal.clone();
        let regressed: [Vec<f64>; LANES] =
            std::array::from_fn(|lane| iv[lane.min(last)].theta().map_or_else(nominal, <[f64]>::to_vec));
        let starts = [regressed, std::array::from_fn(|_| nominal())];
        let spread = self.levels.map_or(Spread::Residuals, Spread::Stated);
        let free = output_error(&recordings, &starts, self.initial, spread);
        let Some(levels) = self.levels.filter(|_| predict) else { return free };
        let [regressed, nominal] = starts;
        let from: [Vec<f64>; LANES] = std::array::from_fn(|lane| match &free[lane] {
            Fit::Converged(found) => found.parameters.iter().chain(&found.intercepts).copied().collect(),
            _ => regressed[lane].clone(),
        });
        prediction_error(&recordings, &[from, regressed, nominal], self.initial, levels)
    }
}

impl From<Fit> for Found {
    fn from(fit: Fit) -> Self {
        match fit {
            Fit::Converged(found) => {
                Self { status: Status::Identified, estimate: Some((found.parameters, found.standard_errors)) }
            }
            Fit::NotConverged(_) => Self { status: Status::NotConverged, estimate: None },
            Fit::NotIdentifiable(_) => Self { status: Status::NotIdentifiable, estimate: None },
        }
    }
}
