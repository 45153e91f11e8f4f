//! The plan in continuous space: sailed, checked against the chart, and what it tells.

use super::check::{Check, Clearance};
use super::error::VoyageError;
use super::information::Information;
use super::prepared::Prepared;
use super::script::Script;
use super::search::Search;
use super::solve::Solved;
use super::tide::Tide;
use crate::Sailed;
use vessel::Invalid;

/// A plan as sailed in simulation.
#[derive(Clone, Debug)]
pub struct Sailing {
    /// Of every step: index into the rehearsed legs.
    pub legs: Vec<usize>,
    /// By the nominal model in the known current.
    pub sailed: Sailed,
    /// By other vessels in unknown currents, the first of them: to be drawn.
    pub runs: Vec<Sailed>,
    /// Against the chart.
    pub check: Check,
    /// What it tells against what the counts promise.
    pub information: Information,
}

impl Prepared {
    /// Sails the plan in continuous space, checks it against the chart and says what it tells.
    ///
    /// # Errors
    /// A command that the model cannot hold, a simulation that diverges; no time.
    pub fn sail(&self, solved: &Solved, search: &Search) -> Result<Sailing, VoyageError> {
        let legs: Vec<usize> =
            solved.solution.steps.iter().map(|step| solved.moves.leg_of_step(step)).collect();
        let script = self.script(solved, &legs);
        let sailed = script.sail(&self.brief.vessel.nominal, [0.0; 2])?;
        let (check, runs) = Clearance::new(self)?.check(&script, &sailed, &legs, search)?;
        let information = self.information_sailed(&legs, &sailed);
        Ok(Sailing { legs, sailed, runs, check, information })
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
    /// Refuses a trial that lasts longer than its slot.
    ///
    /// # Errors
    /// Such a trial.
    pub fn check_slot(&self, sailed: &Sailed) -> Result<(), VoyageError> {
        let Some(Tide { slot_s, .. }) = self.brief.task.tide else { return Ok(()) };
        let lasts_s = sailed.samples.len() as f64 / self.brief.vessel.sample_rate_hz;
        if lasts_s <= slot_s {
            return Ok(());
        }
        Err(VoyageError::NoAnswer(Invalid::new(
            "`tide.until`",
            format!("a slot of {slot_s:.0} s"),
            format!("{lasts_s:.0} s or more, which the plan takes"),
            "begin earlier, ask for fewer maneuvers, or minimise `seconds`",
        )))
    }
}
