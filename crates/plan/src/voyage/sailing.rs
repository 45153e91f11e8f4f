//! The plan in continuous space: simulated, checked against the chart, with its information.

use std::ops::Range;

use refusal::Invalid;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use ship::engine::Pose;
use trial::Piece;

use super::aborts::{LegFailure, WaysOfPlan};
use super::check::{Check, Checked};
use super::check_run::{Aborted, Checking, Script};
use super::clearance::Clearance;
use super::error::{Search, VoyageError};
use super::moment_sums::{MomentSums, Summing};
use super::prepared::Prepared;
use super::solve::{Moves, Solved};
use super::task::{AbortRule, Slot};
use crate::lattice::{Problem, Solution};
use crate::leg::turned_back;
use crate::{Fix, Sailed, SampledVessel};

/// Most searches for a plan that passes its check.
const ROUNDS: u32 = 12;
/// Most counter-examples of a round, over all legs.
const MOST_COUNTER_EXAMPLES: usize = 400;

/// A simulated plan.
#[derive(Clone, Debug)]
pub struct Sailing {
    /// The leg of every step.
    pub legs: Vec<usize>,
    /// The trajectory of the nominal model in the known current.
    pub sailed: Sailed,
    /// Tracks of the first sampled vessels in unknown currents, for drawing.
    pub runs: Vec<Vec<Fix>>,
    /// The check against the chart.
    pub check: Check,
    /// Its information, against the prediction of the counts.
    pub information: Information,
    /// What becomes of the ship if it fails, by step; none before the plan has passed its check.
    pub failures: Vec<LegFailure>,
}

/// One round of search and check.
struct Round {
    /// Its number, from 1.
    number: u32,
    solved: Solved,
    sailing: Sailing,
    /// Steps that violated a margin or a tolerance, each with the vessel.
    counter_examples: Vec<(usize, SampledVessel)>,
    ways_out: SailedWays,
}

/// The ways out of a plan, with what became of all vessels on each, and the poses of the nominal one.
type SailedWays = (WaysOfPlan, Vec<(Aborted, Vec<Pose>)>);

/// The part of a round that is kept while the next one is searched, so that its plan can be simulated again.
struct Last {
    number: u32,
    moves: Moves,
    problem: Problem,
    solution: Solution,
}

impl Round {
    /// The counter-examples by leg, and the rest of the round. The waters are dropped, since they need most
    /// memory and can be computed again.
    fn ended(self) -> (Vec<(usize, SampledVessel)>, Last) {
        let Solved { moves, problem, solution, .. } = self.solved;
        let kept = self.counter_examples.into_iter().take(MOST_COUNTER_EXAMPLES);
        let by_leg = kept.map(|(step, who)| (self.sailing.legs[step], who)).collect();
        (by_leg, Last { number: self.number, moves, problem, solution })
    }
}

impl Prepared {
    /// Plans and simulates until the proved plan passes its check: vessels that violated a margin or a
    /// tolerance become counter-examples for their leg, and the search begins again. If that leaves no plan,
    /// the last one is returned if `keep_unsafe`; likewise if none passes after many rounds.
    ///
    /// # Errors
    /// As [`Self::solve`], with the results of the checks; a simulation that diverges; the time limit.
    pub fn plan(&mut self, search: &Search, keep_unsafe: bool) -> Result<(Solved, Sailing), VoyageError> {
        let (clearance, solved) =
            rayon::join(|| Clearance::new(self, search.keep_going), || self.solve(search));
        let clearance = clearance?;
        let solved = solved.map_err(|error| error.because(0, self.widest()))?;
        let mut round = self.round(&clearance, (1, solved), search)?;
        while !round.counter_examples.is_empty() && round.number < ROUNDS {
            let next = round.number + 1;
            let key = self.brief.task.safety.key();
            let fault = round.sailing.check.worst.as_ref().and_then(|worst| worst.faults(0.0, key).pop());
            let (counter_examples, last) = round.ended();
            // It stays in memory only if it may be returned.
            let last = keep_unsafe.then_some(last);
            let kept = last.as_ref().map_or(0, |last| self.last_bytes(&last.moves, &counter_examples));
            let search_left = search.reserving(kept);
            let next_round = self.next_round(counter_examples, (next, keep_unsafe), &clearance, &search_left);
            round = match (next_round, last) {
                (Ok(round), _) => round,
                (Err(_), Some(last)) => return self.simulate_again(last, &clearance, search),
                (Err(error), None) => return Err(error.because(next - 1, fault)),
            };
        }
        self.with_failures((round.solved, round.sailing), round.ways_out, &clearance, search)
    }

    /// A plan with what becomes of the ship if it fails. Where abort tracks are required, lacking ones are a fault.
    fn with_failures(
        &self,
        (solved, mut sailing): (Solved, Sailing),
        (ways, aborted): SailedWays,
        clearance: &Clearance,
        search: &Search,
    ) -> Result<(Solved, Sailing), VoyageError> {
        let plan = (&solved, &sailing.sailed);
        sailing.failures = self.failures(plan, ways, aborted, clearance, search)?;
        let name = |step: usize| self.legs[sailing.legs[step]].name.clone();
        let lacking = LegFailure::without_abort(&sailing.failures, name);
        if let (AbortRule::Required, Some(legs)) = (self.brief.task.failing.abort, lacking) {
            sailing.check.safe = false;
            sailing.check.faults.push(format!("no abort track from step {legs}: lower `abort_room_m`"));
        }
        let shallow = SailedPlan { prepared: self, solved: &solved, sailing: &sailing }.too_shallow();
        sailing.check.safe &= shallow.is_empty();
        sailing.check.faults.extend(shallow);
        Ok((solved, sailing))
    }

    /// The last plan before a round without one, with its complete check.
    fn simulate_again(
        &self,
        Last { number, moves, problem, solution }: Last,
        clearance: &Clearance,
        search: &Search,
    ) -> Result<(Solved, Sailing), VoyageError> {
        let waters = self.waters(search.keep_going)?;
        let solved = Solved { waters, moves, problem, solution, front: Vec::new() };
        let Round { solved, sailing, ways_out, .. } =
            self.simulate(solved, clearance, (number, true), search)?;
        self.with_failures((solved, sailing), ways_out, clearance, search)
    }

    /// A round after `counter_examples`, by leg; if it has no plan, they are removed again if `keep`.
    fn next_round(
        &mut self,
        counter_examples: Vec<(usize, SampledVessel)>,
        (number, keep): (u32, bool),
        clearance: &Clearance,
        search: &Search,
    ) -> Result<Round, VoyageError> {
        let before = Some(self.learn(counter_examples, search)?).filter(|_| keep);
        let solved = self.check_offered().and_then(|()| self.solve(search));
        let next = solved.and_then(|solved| self.round(clearance, (number, solved), search));
        if let (Err(_), Some(before)) = (&next, before) {
            self.know(before);
        }
        next
    }

    /// Simulates a solution.
    fn round(
        &self,
        clearance: &Clearance,
        (number, solved): (u32, Solved),
        search: &Search,
    ) -> Result<Round, VoyageError> {
        self.simulate(solved, clearance, (number, number == ROUNDS), search)
    }

    /// Simulates the plan in continuous space, checks it against the chart and computes its information and
    /// counter-examples. The front is searched concurrently with the check.
    fn simulate(
        &self,
        mut solved: Solved,
        clearance: &Clearance,
        (round, is_last): (u32, bool),
        search: &Search,
    ) -> Result<Round, VoyageError> {
        let legs: Vec<usize> = solved.solution.steps.iter().map(|at| solved.moves.leg_of_step(at)).collect();
        let ways = self.ways_of(&solved, search)?;
        let script = self.script(&solved, &legs, &ways);
        let (sailed, aborts) = script.nominal()?;
        let left = self.within_check(&solved.moves, (round, sailed.samples.len()), search)?;
        let checking = Checking { script: &script, clearance, legs: &legs, nominal: &sailed, round, is_last };
        let (Checked { check, tracks, counter_examples, aborted }, front) = checking
            .check(search, || self.front(&solved.problem, Some(&solved.solution), &solved.moves, &left))?;
        let information = self.information_of_plan(&legs, &sailed)?;
        solved.front = front.unwrap_or_default();
        let failures = Vec::new();
        let nominal = |(mut all, poses): (Aborted, Vec<Pose>)| {
            let mut passage = clearance.open();
            poses.iter().for_each(|pose| clearance.add(&mut passage, *pose, false));
            all.add(passage.clearance_m, self.brief.task.safety.margin_m, true);
            (all, poses)
        };
        let aborted = aborted.into_iter().zip(aborts).map(nominal).collect();
        let sailing = Sailing { legs, sailed, runs: tracks, check, information, failures };
        Ok(Round { number: round, solved, sailing, counter_examples, ways_out: (ways, aborted) })
    }

    fn script<'a>(&'a self, solved: &Solved, legs: &[usize], ways: &WaysOfPlan) -> Script<'a> {
        let steps = solved.solution.steps.iter().zip(legs);
        let start = solved.problem.start();
        let (level, mode) = self.grid.level_and_mode(start.layer);
        Script {
            prepared: self,
            legs: steps.map(|(step, leg)| (self.node(step.from), &self.legs[*leg].leg)).collect(),
            aborts: self.legs_of_ways(solved, ways),
            start: self.grid.pose(start.i, start.j, level),
            speed_m_s: self.grid.modes[mode].speed_m_s,
        }
    }

    /// Refuses a trial that exceeds its slot, or that of its tide.
    ///
    /// # Errors
    /// Such a trial.
    pub fn check_slot(&self, sailed: &Sailed) -> Result<(), VoyageError> {
        let task = &self.brief.task;
        let lasts_s = sailed.samples.len() as f64 / self.brief.vessel.sample_rate_hz;
        let tide = task.tide.map(|tide| Slot { key: "tide.until", lasts_s: tide.slot_s });
        let mut slots = tide.into_iter().chain(task.slot);
        let Some(slot) = slots.find(|slot| lasts_s > slot.lasts_s) else { return Ok(()) };
        Err(VoyageError::NoAnswer(Invalid::new(
            format!("`{}`", slot.key),
            format!("a slot of {:.0} s", slot.lasts_s),
            format!("{lasts_s:.0} s or more, which the plan takes"),
            "begin earlier, request fewer maneuvers, or minimise `seconds`",
        )))
    }
}

/// log|det| of the information, per the nominal model; none where a direction is not excited at all.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Information {
    /// Promised by the counts: each use adds the moments of its piece.
    pub predicted_log_det: Option<f64>,
    /// Of the informative parts of the trajectory actually sailed.
    pub realised_log_det: Option<f64>,
    /// The same, with everything between them. None of a ship with forces: simulated without her autopilot for minutes, an
    /// unstable one would seem to tell of her numbers without bound.
    pub whole_log_det: Option<f64>,
    /// exp((realised − predicted)/p).
    pub efficiency: Option<f64>,
    /// exp((predicted − optimum)/p) for the design's shares over the same time, where a design was given.
    pub design_efficiency: Option<f64>,
    /// p.
    pub dimension: u64,
}

impl Prepared {
    /// The information of `sailed`, against the prediction of its `legs`.
    fn information_of_plan(&self, legs: &[usize], sailed: &Sailed) -> Result<Information, Invalid> {
        let summing = self.brief.summing()?;
        let predicted = self.promised(legs);
        let mut realised = MomentSums::default();
        let mut start = 0;
        for part in sailed.samples.chunk_by(|a, b| a.leg == b.leg && a.informative == b.informative) {
            let end = start + part.len();
            if part[0].informative {
                realised.add(&self.information_of(&summing, sailed, start..end), 1.0);
            }
            start = end;
        }
        let known = |x: f64| Some(x).filter(|x| x.is_finite());
        let whole = || self.information_of(&summing, sailed, 0..sailed.samples.len()).log_det();
        let (promise, information, p) = (predicted.log_det(), realised.log_det(), predicted.dimension());
        Ok(Information {
            predicted_log_det: known(promise),
            realised_log_det: known(information),
            whole_log_det: (!summing.is_of_segments()).then(whole).and_then(known),
            efficiency: known(libm::exp((information - promise) / p as f64)),
            design_efficiency: self.design_efficiency(&summing, legs, &predicted),
            dimension: p as u64,
        })
    }

    /// The pieces of the informative ones among `legs`.
    fn pieces_of<'a>(&'a self, legs: &'a [usize]) -> impl Iterator<Item = usize> + 'a {
        legs.iter().filter_map(|leg| self.legs[*leg].leg.purpose.piece())
    }

    fn promised(&self, legs: &[usize]) -> MomentSums {
        let mut promised = MomentSums::default();
        self.pieces_of(legs).for_each(|piece| promised.add(&self.information[piece], 1.0));
        promised
    }

    /// The information of a segment; of a ship with forces as she moves through the water, which the known current only carries.
    fn information_of(&self, summing: &Summing, sailed: &Sailed, range: Range<usize>) -> MomentSums {
        let sample = &sailed.samples[range.clone()];
        let inputs: Vec<f64> = sample.iter().flat_map(|s| s.inputs.iter().copied()).collect();
        let after = sailed.samples.get(range.end).map(|s| s.state);
        let after = after.or(sailed.ends.last().map(|(_, state)| *state)).unwrap_or_default();
        let mut states: Vec<f64> = sample.iter().map(|s| s.state).chain([after]).flatten().collect();
        if summing.is_of_segments() {
            let [along, across] =
                turned_back(self.brief.task.known_current_m_s, sample.first().map_or(0.0, |s| s.pose.psi));
            (states[0], states[1]) = (states[0] - along, states[1] - across);
        }
        summing.of(&inputs, &states)
    }

    /// The counts compared with the design's shares over the same time in maneuvers.
    fn design_efficiency(&self, summing: &Summing, legs: &[usize], counted: &MomentSums) -> Option<f64> {
        let (design, vessel) = (self.brief.design.as_ref()?, &self.brief.vessel);
        let samples: f64 = self.pieces_of(legs).map(|piece| self.pieces[piece].samples as f64).sum();
        let mut best = MomentSums::default();
        for run in &self.brief.dictionary {
            let share = design.share.get(&run.segments[0].maneuver).copied().unwrap_or(0.0);
            if share > 0.0 {
                let of_piece = summing.of_piece(&Piece::whole(vessel, run));
                best.add(&of_piece, share * samples / run.samples() as f64);
            }
        }
        let efficiency = libm::exp((counted.log_det() - best.log_det()) / counted.dimension() as f64);
        efficiency.is_finite().then_some(efficiency)
    }
}

/// A trial with its plan and the simulation of it.
#[derive(Clone, Copy, Debug)]
pub struct SailedPlan<'a> {
    /// Chart, lattice and moves.
    pub prepared: &'a Prepared,
    /// The cheapest walk.
    pub solved: &'a Solved,
    /// The simulated plan.
    pub sailing: &'a Sailing,
}
