//! Instrumental variables whose instruments and prefilter come from the estimate: the start of searches.

use numerics::lanes::{groups, interleave};
use regression::runs::Prepared;
use regression::{MeanRemoval, Noise, Outcome, estimate_prefiltered};
use ship::engine::Run;
use ship::model::Vessel;

use super::found::Regressed;
use crate::predictor::NoiseModel;

/// Refinements after which the estimate is a good start for searches.
const ROUNDS: usize = 2;
/// Converged if a round changes no parameter by more than this share of its standard error.
const ENOUGH: f64 = 0.01;

/// Parameters near those of `runs`, from the estimates `iv`; none without such an estimate. If the simulation with the first one
/// diverges, the nominal model's instruments and filter are used instead; if the second does, or its instruments identify nothing,
/// the last good estimate is kept.
pub(super) fn refined(
    vessel: &Vessel,
    runs: &[Run],
    iv: &[Regressed],
    removal: MeanRemoval,
    levels: Option<&NoiseModel>,
) -> Vec<Option<Vec<f64>>> {
    let noise = levels.and_then(NoiseModel::white);
    let lengths: Vec<usize> = runs.iter().map(Run::samples).collect();
    let group = |group: std::ops::Range<usize>| {
        let mut batch = Refinement::new(vessel, &runs[group.clone()], &iv[group], removal, noise);
        for round in 0..ROUNDS {
            if batch.done.iter().all(|done| *done) {
                break;
            }
            batch.round(round == 0);
        }
        batch.found
    };
    groups(&lengths).into_iter().flat_map(group).collect()
}

/// Up to [`numerics::LANES`] runs.
struct Refinement<'a> {
    vessel: &'a Vessel,
    removal: MeanRemoval,
    noise: Option<Noise>,
    /// The runs with the latest simulations as instruments.
    runs: Prepared<'a>,
    found: Vec<Option<Vec<f64>>>,
    /// The models of the simulations.
    models: Vec<Vec<f64>>,
    done: Vec<bool>,
}

impl<'a> Refinement<'a> {
    fn new(
        vessel: &'a Vessel,
        runs: &[Run],
        iv: &[Regressed],
        removal: MeanRemoval,
        noise: Option<Noise>,
    ) -> Self {
        let found: Vec<Option<Vec<f64>>> = iv.iter().map(|r| r.found.theta().map(<[f64]>::to_vec)).collect();
        Self {
            vessel,
            removal,
            noise,
            runs: Prepared::regressed(vessel, runs),
            models: found.iter().map(|own| own.as_ref().unwrap_or(&vessel.nominal).clone()).collect(),
            done: found.iter().map(Option::is_none).collect(),
            found,
        }
    }

    fn round(&mut self, first: bool) {
        let parameters = interleave(&self.models.iter().map(Vec::as_slice).collect::<Vec<_>>());
        self.runs.simulate(&parameters);
        let batch = self.runs.batch();
        let outcomes = estimate_prefiltered(&batch, &parameters, self.removal, self.noise.as_ref());
        for (lane, outcome) in outcomes.into_iter().enumerate().take(self.found.len()) {
            let diverged = self.runs.diverged(lane).is_some();
            if diverged && first && self.models[lane] != self.vessel.nominal {
                self.models[lane].clone_from(&self.vessel.nominal);
            } else {
                self.take(lane, (!diverged).then_some(outcome));
            }
        }
    }

    /// Takes the outcome of a run's round; `None` if its simulation diverged.
    fn take(&mut self, lane: usize, outcome: Option<Outcome>) {
        if self.done[lane] {
            return;
        }
        let Some(Outcome::Identified(next)) = outcome else {
            self.done[lane] = true;
            return;
        };
        if let Some(theta) = &self.found[lane] {
            let moves = next.parameters.iter().zip(theta).zip(&next.standard_errors);
            // At a bound a parameter neither moves nor has an error.
            let still = |moved: f64| moved <= ENOUGH || moved.is_nan();
            self.done[lane] = moves.map(|((a, b), se)| (a - b).abs() / se).all(still);
        }
        self.models[lane].clone_from(&next.parameters);
        self.found[lane] = Some(next.parameters);
    }
}
