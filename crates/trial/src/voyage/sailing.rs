//! The plan in continuous space: sailed, checked against the chart, and what it tells.

use lattice::{Problem, Solution};
use refusal::Invalid;

use super::check::{Check, Checked, Checking};
use super::clearance::Clearance;
use super::error::VoyageError;
use super::information::Information;
use super::moves::Moves;
use super::prepared::Prepared;
use super::script::Script;
use super::search::Search;
use super::solve::Solved;
use super::task::Slot;
use crate::{Fix, Rehearser, Sailed};

/// How often a plan is searched before the last one has to do.
const ROUNDS: u32 = 12;
/// Who teaches a leg in a round: so many at most, over all legs.
const PUPILS: usize = 400;

/// A plan as sailed in simulation.
#[derive(Clone, Debug)]
pub struct Sailing {
    /// Of every step: index into the rehearsed legs.
    pub legs: Vec<usize>,
    /// By the nominal model in the known current.
    pub sailed: Sailed,
    /// By other vessels in unknown currents, the first of them: to be drawn.
    pub runs: Vec<Vec<Fix>>,
    /// Against the chart.
    pub check: Check,
    /// What it tells against what the counts promise.
    pub information: Information,
}

/// One round of search and check.
struct Round {
    /// Which one, from 1.
    number: u32,
    solved: Solved,
    sailing: Sailing,
    /// Steps that broke a margin or missed a tolerance, and who sailed them.
    taught: Vec<(usize, Rehearser)>,
}

/// What is left of a round while the next one is searched: all that its plan takes to be sailed again.
struct Last {
    number: u32,
    moves: Moves,
    problem: Problem,
    solution: Solution,
}

impl Round {
    /// Who is to rehearse which legs, and what may be wanted after all. Where legs fit can be told again: it takes most memory.
    fn ended(self) -> (Vec<(usize, Rehearser)>, Last) {
        let Self { number, solved: Solved { moves, problem, solution, .. }, sailing, taught } = self;
        let taught = taught.into_iter().take(PUPILS).map(|(step, who)| (sailing.legs[step], who)).collect();
        (taught, Last { number, moves, problem, solution })
    }
}

impl Prepared {
    /// Plans and sails until what is proved is what can be sailed: legs that broke a margin or missed a tolerance in a check
    /// are rehearsed by whoever failed them, too, and the search begins again. Where that leaves no plan, the last one is given if
    /// `keep_unsafe`; so it is where none passes in many rounds.
    ///
    /// # Errors
    /// As [`Self::solve`], with what the checks showed; a simulation that diverges; no time.
    pub fn plan(&mut self, search: &Search, keep_unsafe: bool) -> Result<(Solved, Sailing), VoyageError> {
        let (clearance, solved) = rayon::join(|| Clearance::new(self, search.go_on), || self.solve(search));
        let clearance = clearance?;
        let mut round = self.round(&clearance, (1, solved?), search)?;
        while !round.taught.is_empty() && round.number < ROUNDS {
            let next = round.number + 1;
            let (taught, last) = round.ended();
            // Only where it may be wanted after all does it stay in memory.
            let last = keep_unsafe.then_some(last);
            let kept = last.as_ref().map_or(0, |last| self.last_bytes(&last.moves, &taught));
            let next_round = self.again(taught, (next, keep_unsafe), &clearance, &search.beside(kept));
            round = match (next_round, last) {
                (Ok(round), _) => round,
                (Err(_), Some(last)) => return self.sail_again(last, &clearance, search),
                (Err(error), None) => return Err(error.after(next - 1)),
            };
        }
        Ok((round.solved, round.sailing))
    }

    /// The plan of a round after which there was none, with all of its check.
    fn sail_again(
        &self,
        Last { number, moves, problem, solution }: Last,
        clearance: &Clearance,
        search: &Search,
    ) -> Result<(Solved, Sailing), VoyageError> {
        let waters = self.waters(search.go_on)?;
        let mut solved = Solved { waters, moves, problem, solution, front: Vec::new() };
        let (sailing, _) = self.sail(&mut solved, clearance, (number, true), search)?;
        Ok((solved, sailing))
    }

    /// A round after one that taught `taught`, by leg; where it leaves no plan, that is forgotten again if `keep`.
    fn again(
        &mut self,
        taught: Vec<(usize, Rehearser)>,
        (number, keep): (u32, bool),
        clearance: &Clearance,
        search: &Search,
    ) -> Result<Round, VoyageError> {
        let before = Some(self.learn(taught, search)?).filter(|_| keep);
        let solved = self.check_offered().and_then(|()| self.solve(search));
        let next = solved.and_then(|solved| self.round(clearance, (number, solved), search));
        if let (Err(_), Some(before)) = (&next, before) {
            self.know(before);
        }
        next
    }

    /// Sails what a search found.
    fn round(
        &self,
        clearance: &Clearance,
        (number, mut solved): (u32, Solved),
        search: &Search,
    ) -> Result<Round, VoyageError> {
        let (sailing, taught) = self.sail(&mut solved, clearance, (number, number == ROUNDS), search)?;
        Ok(Round { number, solved, sailing, taught })
    }

    /// Sails the plan in continuous space, checks it against the chart and says what it tells, and who failed which steps. The
    /// front is searched beside the check.
    fn sail(
        &self,
        solved: &mut Solved,
        clearance: &Clearance,
        (round, is_last): (u32, bool),
        search: &Search,
    ) -> Result<(Sailing, Vec<(usize, Rehearser)>), VoyageError> {
        let legs: Vec<usize> =
            solved.solution.steps.iter().map(|step| solved.moves.leg_of_step(step)).collect();
        let script = self.script(solved, &legs);
        let sailed = script.sailed(&self.brief.vessel.nominal, [0.0; 2])?;
        let left = self.within_check(&solved.moves, (round, sailed.samples.len()), search)?;
        let checking = Checking { script: &script, clearance, legs: &legs, nominal: &sailed, round, is_last };
        let (Checked { check, tracks, taught }, front) =
            checking.check(search, || self.front(&solved.problem, &solved.moves, &left))?;
        let information = self.information_sailed(&legs, &sailed);
        solved.front = front.unwrap_or_default();
        Ok((Sailing { legs, sailed, runs: tracks, check, information }, taught))
    }

    fn script<'a>(&'a self, solved: &Solved, legs: &[usize]) -> Script<'a> {
        let steps = solved.solution.steps.iter().zip(legs);
        let start = solved.problem.start();
        let (level, mode) = self.grid.level_and_mode(start.layer);
        Script {
            prepared: self,
            legs: steps.map(|(step, leg)| (self.node(step.from), &self.rehearsed[*leg].leg)).collect(),
            start: self.grid.pose(start.i, start.j, level),
            speed_m_s: self.grid.modes[mode].speed_m_s,
        }
    }
}

impl Prepared {
    /// Refuses a trial that lasts longer than its slot, or than that of its tide.
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
            "begin earlier, ask for fewer maneuvers, or minimise `seconds`",
        )))
    }
}
