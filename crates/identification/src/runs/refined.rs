//! Instrumental variables whose instruments and prefilter come from the estimate.

use std::ops::Range;

use engine::Run;
use model::Vessel;
use numerics::lanes::{groups, interleave};
use regression::runs::Prepared;
use regression::{MeanRemoval, Noise, Outcome, estimate_prefiltered};

use super::found::{Found, Regressed};
use crate::EstimateStatus;
use crate::predictor::Levels;

/// Maximum number of refinement iterations.
const ROUNDS: usize = 8;
/// Iterations after which the estimate is a good start for searches.
pub(super) const NEAR: usize = 2;
/// Converged if a round changes no parameter by more than this share of its standard error.
const ENOUGH: f64 = 0.01;

/// Refined estimates of runs.
#[derive(Default)]
pub(super) struct Refined {
    /// After [`NEAR`] iterations.
    pub near: Vec<Found>,
    /// After all of them, if requested.
    pub last: Vec<Found>,
}

/// Refines the estimates `iv` of `runs`, `to_the_end` or as far as searches need it. If the simulation with the first
/// one diverges, the nominal model's instruments and filter are used instead; if a later one does, or its instruments
/// identify nothing, the last good estimate is kept and marked so.
pub(super) fn refine(
    vessel: &Vessel,
    runs: &[Run],
    iv: &[Regressed],
    removal: MeanRemoval,
    levels: Option<&Levels>,
    to_the_end: bool,
) -> Refined {
    let noise = levels.and_then(Levels::white);
    let lengths: Vec<usize> = runs.iter().map(Run::samples).collect();
    let mut all = Refined::default();
    for group in groups(&lengths) {
        let mut batch = Refinement::new(vessel, &runs[group.clone()], &iv[group], removal, noise);
        batch.refine(0..NEAR);
        all.near.extend_from_slice(&batch.found);
        if to_the_end {
            batch.refine(NEAR..ROUNDS);
            all.last.extend(batch.found);
        }
    }
    all
}

/// Up to [`numerics::LANES`] runs.
struct Refinement<'a> {
    vessel: &'a Vessel,
    removal: MeanRemoval,
    noise: Option<Noise>,
    /// The runs with the latest simulations as instruments.
    runs: Prepared<'a>,
    found: Vec<Found>,
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
        let found = iv.iter().map(|r| r.found.clone());
        Self {
            vessel,
            removal,
            noise,
            runs: Prepared::regressed(vessel, runs),
            found: found.collect(),
            models: iv.iter().map(|r| r.found.theta().unwrap_or(&vessel.nominal).to_vec()).collect(),
            done: iv.iter().map(|r| r.found.theta().is_none()).collect(),
        }
    }

    fn refine(&mut self, rounds: Range<usize>) {
        for round in rounds {
            if self.done.iter().all(|done| *done) {
                break;
            }
            self.round(round == 0);
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
            self.found[lane].status = EstimateStatus::Kept;
            self.done[lane] = true;
            return;
        };
        if let Some((theta, _)) = &self.found[lane].estimate {
            let moves = next.parameters.iter().zip(theta).zip(&next.standard_errors);
            // At a bound a parameter neither moves nor has an error.
            let still = |moved: f64| moved <= ENOUGH || moved.is_nan();
            self.done[lane] = moves.map(|((a, b), se)| (a - b).abs() / se).all(still);
        }
        self.models[lane].clone_from(&next.parameters);
        self.found[lane].estimate = Some((next.parameters, next.standard_errors));
        self.found[lane].covariance = Some(next.covariance);
    }
}
