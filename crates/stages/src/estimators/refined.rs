//! Instrumental variables whose instruments are simulated again with the estimate.

use identification::{Batch, MeanRemoval, Outcome};
use vessel::{LANES, Lane, Vessel, check_diverged, simulate};

use super::rows::{Found, Regressed};
use crate::estimates::Status;
use crate::lanes::{groups, interleave};
use crate::trajectories::Run;

/// Most often that instruments are simulated again.
const ROUNDS: usize = 4;
/// A round that moves no parameter by more than this share of its standard error is the last.
const ENOUGH: f64 = 0.01;

/// Refines the estimates `iv` of `runs`. Where a simulation diverges, or instruments made with it identify nothing, the last
/// good estimate is kept and marked so.
pub(super) fn refine(vessel: &Vessel, runs: &[Run], iv: &[Regressed], removal: MeanRemoval) -> Vec<Found> {
    let lengths: Vec<usize> = runs.iter().map(Run::samples).collect();
    let mut all = Vec::with_capacity(runs.len());
    for group in groups(&lengths) {
        let mut batch = Refinement::new(vessel, &runs[group.clone()], &iv[group], removal);
        for _ in 0..ROUNDS {
            if batch.done.iter().all(|done| *done) {
                break;
            }
            batch.round();
        }
        all.extend(batch.found);
    }
    all
}

/// Up to [`LANES`] runs.
struct Refinement<'a> {
    vessel: &'a Vessel,
    removal: MeanRemoval,
    initial: [Lane; 3],
    measured: Vec<Lane>,
    exogenous: Vec<Lane>,
    starts: Vec<Vec<usize>>,
    found: Vec<Found>,
    done: Vec<bool>,
}

impl<'a> Refinement<'a> {
    fn new(vessel: &'a Vessel, runs: &[Run], iv: &[Regressed], removal: MeanRemoval) -> Self {
        let last = runs.len() - 1;
        let start = |d: usize| Lane(std::array::from_fn(|lane| runs[lane.min(last)].initial[d]));
        let found = iv.iter().map(|r| Found { status: r.found.status, estimate: r.found.estimate.clone() });
        Self {
            vessel,
            removal,
            initial: [0, 1, 2].map(start),
            measured: interleave(&runs.iter().map(|r| r.measured.as_slice()).collect::<Vec<_>>()),
            exogenous: interleave(&runs.iter().map(|r| r.exogenous.as_slice()).collect::<Vec<_>>()),
            starts: runs.iter().map(Run::starts).collect(),
            found: found.collect(),
            done: iv.iter().map(|r| r.theta().is_none()).collect(),
        }
    }

    fn round(&mut self) {
        let states = self.states();
        let last = self.starts.len() - 1;
        let batch = Batch {
            model: &self.vessel.model,
            measured: &self.measured,
            instrument_states: &states,
            exogenous: &self.exogenous,
            segments: std::array::from_fn(|lane| self.starts[lane.min(last)].as_slice()),
        };
        let outcomes = identification::estimate(&batch, self.removal);
        for (lane, outcome) in outcomes.into_iter().enumerate().take(self.found.len()) {
            let diverged = check_diverged(states.iter().map(|s| s[lane])).is_some();
            self.take(lane, (!diverged).then_some(outcome));
        }
    }

    /// Simulates every run with its estimate.
    fn states(&self) -> Vec<Lane> {
        let theta = |lane: usize| {
            let found = &self.found[lane.min(self.found.len() - 1)];
            found.estimate.as_ref().map_or(self.vessel.nominal.as_slice(), |(theta, _)| theta.as_slice())
        };
        let parameter = |i: usize| Lane(std::array::from_fn::<f64, LANES, _>(|lane| theta(lane)[i]));
        let parameters: Vec<Lane> = (0..self.vessel.model.parameters()).map(parameter).collect();
        let mut states = vec![Lane::ZERO; self.measured.len()];
        simulate(&self.vessel.model, &parameters, self.initial, &self.exogenous, &[], &mut states);
        states
    }

    /// The outcome of a run's round; none where its simulation diverged.
    fn take(&mut self, lane: usize, outcome: Option<Outcome>) {
        if self.done[lane] {
            return;
        }
        let Some(Outcome::Identified(next)) = outcome else {
            self.found[lane].status = Status::Kept;
            self.done[lane] = true;
            return;
        };
        if let Some((theta, _)) = &self.found[lane].estimate {
            let moves = next.parameters.iter().zip(theta).zip(&next.standard_errors);
            self.done[lane] = moves.map(|((a, b), se)| (a - b).abs() / se).all(|moved| moved <= ENOUGH);
        }
        self.found[lane].estimate = Some((next.parameters, next.standard_errors));
    }
}
