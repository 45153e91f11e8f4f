//! The check of a plan in continuous space: clearance of the hull from charted obstacles and settling at the
//! ends of legs, by the nominal model, and by sampled vessels in unknown currents.

use numerics::statistics::{quantile, sorted, wilson};
use rayon::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::clearance::{Clearance, Passage};
use super::error::VoyageError;
use super::prepared::Prepared;
use super::script::Script;
use super::search::Search;
use crate::leg::turned_back;
use crate::{Astray, End, Fix, Sailed, SampledVessel};

/// Tracks that are kept for drawing.
pub(super) const TRACKS: u32 = 200;
/// Runs after which a check with counter-examples ends: the next plan is checked instead.
const FIRST_RUNS: u32 = 64;
/// Probability, over all rounds, that a bound does not hold.
const DOUBT: f64 = 0.05;
/// Fraction by which the simulated time may differ from the proved one.
const LONGER: f64 = 0.02;

/// The plan simulated in continuous space.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Check {
    /// Whether the hull keeps its margin and every leg its tolerance in every simulation, in the time that is proved.
    pub safe: bool,
    /// What is broken, in words; empty for a safe plan.
    pub faults: Vec<String>,
    /// Least distance of the hull from anything charted as an obstacle, nominal model, known current \[m\].
    pub clearance_m: f64,
    /// Whether the hull stays clear.
    pub clear: bool,
    /// Distance that was asked for \[m\].
    pub margin_m: f64,
    /// By how much the nominal track falls short of that; 0 where it keeps it \[m\].
    pub shortfall_m: f64,
    /// Distances are measured as far as this \[m\].
    pub sight_m: f64,
    /// Bound on the unknown current \[m/s\].
    pub unknown_current_m_s: f64,
    /// Bound on the relative error of every parameter.
    pub parameter_error: f64,
    /// Of the currents and parameters.
    pub seed: u64,
    /// Simulations of the whole plan, each with a constant current of its own, by vessels whose parameters are even within
    /// that bound.
    pub runs: u64,
    /// How many vessels were drawn for them.
    pub vessels: u64,
    /// Of which touched an obstacle, or went where the chart was not read.
    pub aground: u64,
    /// The share of them that this leaves possible, Wilson's 95 %.
    pub aground_interval: [f64; 2],
    /// Vessels of which a run went aground.
    pub vessels_aground: u64,
    /// Going aground is less probable than this, 95 % confidence; runs count as independent, which those of one vessel are
    /// not. None where a run went aground.
    pub aground_bound: Option<f64>,
    /// The same where only vessels count as independent: the share of vessels that go aground in any of so many currents.
    pub aground_bound_by_vessels: Option<f64>,
    /// Runs that came nearer than the margin, those aground among them.
    pub below_margin: u64,
    /// Ends of legs in all runs.
    pub ends: u64,
    /// Of which lie beyond a tolerance.
    pub ends_astray: u64,
    /// The largest part of a tolerance that the nominal vessel uses at the end of any leg.
    pub tolerance_used: f64,
    /// Time that the proved plan takes, leg by leg, each from its node \[s\].
    pub proved_s: f64,
    /// Time that the nominal vessel takes for all of it \[s\].
    pub sailed_s: f64,
    /// Time that the runs take: least, median, most \[s\].
    pub sailed_quantiles_s: [f64; 3],
    /// How often the plan was searched, with what earlier checks taught; every check draws anew.
    pub rounds: u64,
    /// Runs that left the lattice's area, which is no obstacle.
    pub left_area: u64,
    /// Least clearance of each run: smallest, 5 %, median \[m\].
    pub clearance_quantiles_m: [f64; 3],
    /// The same runs without corrections between maneuvers (the autopilot reckons with the nominal track only).
    pub aground_open_loop: u64,
}

/// The result of a check.
pub(super) struct Checked {
    pub check: Check,
    /// Tracks for drawing.
    pub tracks: Vec<Vec<Fix>>,
    /// Steps that violated a margin or a tolerance, each with the vessel and its initial offset.
    pub counter_examples: Vec<(usize, SampledVessel)>,
}

/// A plan that is checked.
pub(super) struct Checking<'a> {
    pub script: &'a Script<'a>,
    pub clearance: &'a Clearance,
    /// The leg of every step.
    pub legs: &'a [usize],
    /// The trajectory of the nominal model without unknown current.
    pub nominal: &'a Sailed,
    /// Number of checks so far, including this one.
    pub round: u32,
    /// Whether all runs are simulated, even after one has failed.
    pub is_last: bool,
}

/// A run of a check.
pub(super) struct Run {
    passage: Passage,
    /// Without corrections, until it runs aground.
    open_loop: Passage,
    /// Ends of legs, and those beyond a tolerance.
    ends: [u64; 2],
    seconds: f64,
    track: Option<Vec<Fix>>,
    /// Steps that began within the tolerance and violated the margin or the tolerance, each with its vessel.
    counter_examples: Vec<(usize, SampledVessel)>,
}

impl Prepared {
    /// The number of runs of a check in this round, and the number of vessels.
    pub(super) fn runs(&self, round: u32) -> [u32; 2] {
        let safety = &self.brief.task.safety;
        let needed = |p: f64| (libm::log(doubt(round)) / libm::log1p(-p)).ceil().max(1.0) as u32;
        let runs = match (safety.runs, safety.aground_probability) {
            (Some(runs), None) => runs,
            (runs, probability) => {
                let needed = needed(probability.unwrap_or(USUAL_PROBABILITY));
                runs.map_or(needed, |runs| runs.max(needed))
            }
        };
        [runs, safety.vessels.unwrap_or(runs).min(runs)]
    }
}

/// The default bound on the probability of running aground.
pub(super) const USUAL_PROBABILITY: f64 = 0.01;

/// Probability that the bound of a round does not hold: halved from round to round, so that the sum is
/// bounded.
fn doubt(round: u32) -> f64 {
    DOUBT * 0.5_f64.powi(round as i32)
}

impl Checking<'_> {
    fn prepared(&self) -> &Prepared {
        self.script.prepared
    }

    /// Simulates the script with sampled parameters and in unknown currents; `concurrent` is executed along
    /// with the last runs, if all of them are simulated.
    ///
    /// # Errors
    /// A simulation that diverges; no time.
    pub(super) fn check<T: Send>(
        &self,
        search: &Search,
        concurrent: impl FnOnce() -> T + Send,
    ) -> Result<(Checked, Option<T>), VoyageError> {
        let [runs, vessels] = self.prepared().runs(self.round);
        let one = |run: u32| {
            if !(search.keep_going)() {
                return Err(VoyageError::OutOfTime("the check of the plan"));
            }
            // A sampled vessel that cannot be simulated is not the fault of a file.
            self.run(run, vessels).map_err(VoyageError::NoAnswer)
        };
        let (mut found, mut counter_examples) = (Vec::new(), Vec::new());
        let (mut next, mut concurrent, mut aside) = (0, Some(concurrent), None);
        while next < runs && (counter_examples.is_empty() || self.is_last) {
            let some = next..(next + FIRST_RUNS.max(next * FIRST_RUNS)).min(runs);
            let simulate = || -> Result<Vec<Run>, VoyageError> {
                let all: Vec<_> = some.clone().into_par_iter().map(one).collect();
                all.into_iter().collect()
            };
            let mut new = match concurrent.take_if(|_| some.end == runs) {
                Some(own) => {
                    let (new, own) = rayon::join(simulate, own);
                    aside = Some(own);
                    new?
                }
                None => simulate()?,
            };
            counter_examples.extend(new.iter_mut().flat_map(|own| std::mem::take(&mut own.counter_examples)));
            found.extend(new);
            next = some.end;
        }
        let check = self.judged(&found, vessels as usize);
        let tracks = found.into_iter().filter_map(|run| run.track).collect();
        Ok((Checked { check, tracks, counter_examples }, aside))
    }

    fn parameters(&self, vessel: u32) -> Vec<f64> {
        self.prepared().brief.drawn(&format!("checked-parameters-{}", self.round), vessel)
    }

    fn unknown(&self, run: u32) -> [f64; 2] {
        self.prepared().brief.current(&format!("unknown-current-{}", self.round), run)
    }

    fn run(&self, run: u32, vessels: u32) -> Result<Run, refusal::Invalid> {
        let (parameters, unknown) = (self.parameters(run % vessels), self.unknown(run));
        let (clearance, rate_hz) = (self.clearance, self.prepared().brief.vessel.sample_rate_hz);
        let mut passages = vec![clearance.open(); self.legs.len()];
        let (mut samples, mut leg) = (0_u64, 0);
        let margin_m = self.prepared().brief.task.safety.margin_m;
        // Some vessels take longer than the nominal one.
        let capacity = self.nominal.samples.len() * 9 / 8;
        let mut track = (run < TRACKS).then(|| Vec::with_capacity(capacity));
        let ends = self.script.simulate(&parameters, unknown, |own| {
            if own.leg > leg {
                // Distances beyond the margin and the least one so far are irrelevant.
                passages[own.leg].clearance_m = passages[leg].clearance_m.max(margin_m);
                leg = own.leg;
            }
            clearance.add(&mut passages[own.leg], own.pose, own.informative);
            samples += 1;
            if let Some(track) = &mut track {
                track.push(Fix { leg: own.leg, pose: own.pose });
            }
        })?;
        // Only running aground matters.
        let mut open_loop = clearance.open();
        open_loop.clearance_m = f64::MIN_POSITIVE;
        self.script.repeat(self.nominal, &parameters, unknown, |own| {
            clearance.add(&mut open_loop, own.pose, own.informative);
            open_loop.clearance_m > 0.0
        });
        let passage = passages.iter().fold(clearance.open(), |a, b| a.and(b));
        // The counter-examples of the last round are not used.
        let counter_examples = if self.is_last {
            Vec::new()
        } else {
            self.counter_examples(run % vessels, run, &passages, &ends)
        };
        let ends = [ends.len() as u64, self.used(&ends).iter().filter(|used| **used > 1.0).count() as u64];
        Ok(Run { passage, open_loop, ends, seconds: samples as f64 / rate_hz, track, counter_examples })
    }

    /// The used fraction of the tolerance at the end of every step.
    fn used(&self, ends: &[End]) -> Vec<f64> {
        let repertoire = self.prepared().repertoire();
        let own = self.script.legs.iter().zip(ends);
        let tolerance = repertoire.approach.tolerance;
        own.map(|((node, leg), end)| {
            let [north, east] = self.prepared().grid.displacement(leg.di, leg.dj);
            repertoire.used_at(&tolerance, leg.to, [node[0] + north, node[1] + east], *end).part
        })
        .collect()
    }

    /// The steps of a run that began within the tolerance and violated the margin or the tolerance, each with
    /// its vessel.
    fn counter_examples(
        &self,
        vessel: u32,
        run: u32,
        passages: &[Passage],
        ends: &[End],
    ) -> Vec<(usize, SampledVessel)> {
        let margin_m = self.prepared().brief.task.safety.margin_m;
        let used = self.used(ends);
        let failed = |step: &usize| {
            let began_well = *step == 0 || used[step - 1] <= 1.0;
            passages[*step].clearance_m < margin_m || (used[*step] > 1.0 && began_well)
        };
        let failures = (0..self.legs.len()).filter(failed);
        failures.map(|step| (step, self.sampled_vessel(vessel, run, step, ends))).collect()
    }

    /// The vessel of a step, with its offset at the beginning.
    fn sampled_vessel(&self, vessel: u32, run: u32, step: usize, ends: &[End]) -> SampledVessel {
        let (node, leg) = self.script.legs[step];
        let grid = &self.prepared().grid;
        let (level, mode) = grid.level_and_mode(leg.from);
        let (heading, speed) = (grid.heading_rad(level), grid.modes[mode].speed_m_s);
        let exact = (self.script.start, [speed, 0.0, 0.0]);
        let (pose, [u, v, r]) = if step == 0 { exact } else { ends[step - 1] };
        let Astray { pose, .. } = Astray::of(pose, [u, v, r], node);
        let [along, across] = turned_back([pose.x, pose.y], heading);
        SampledVessel {
            parameters: self.parameters(vessel),
            current_m_s: turned_back(self.unknown(run), heading),
            off: [along, across, crate::grid::wrap(pose.psi - heading)],
            motion: [u - speed, v, r],
        }
    }

    fn judged(&self, found: &[Run], vessels: usize) -> Check {
        let (prepared, clearance) = (self.prepared(), self.clearance);
        let safety = prepared.brief.task.safety;
        let count = |is: &dyn Fn(&Run) -> bool| found.iter().filter(|run| is(run)).count() as u64;
        let least = sorted(found.iter().map(|run| Some(run.passage.clearance_m)));
        let seconds = sorted(found.iter().map(|run| Some(run.seconds)));
        let mut own = clearance.open();
        self.nominal.samples.iter().for_each(|s| clearance.add(&mut own, s.pose, s.informative));
        let rate_hz = prepared.brief.vessel.sample_rate_hz;
        let (runs, is_aground) = (found.len() as u64, |run: &Run| run.passage.clearance_m <= 0.0);
        let aground = count(&is_aground);
        let mut lost = vec![false; vessels];
        found.iter().enumerate().for_each(|(run, own)| lost[run % vessels] |= is_aground(own));
        let vessels_aground = lost.iter().filter(|lost| **lost).count() as u64;
        let bound = |independent: usize| {
            (aground == 0).then(|| 1.0 - libm::exp(libm::log(doubt(self.round)) / independent as f64))
        };
        let check = Check {
            safe: false,
            faults: Vec::new(),
            clearance_m: own.clearance_m,
            clear: own.clearance_m > 0.0,
            margin_m: safety.margin_m,
            shortfall_m: (safety.margin_m - own.clearance_m).max(0.0),
            sight_m: clearance.sight_m,
            unknown_current_m_s: safety.unknown_current_m_s,
            parameter_error: safety.parameter_error,
            seed: prepared.brief.seed,
            runs,
            vessels: vessels as u64,
            aground,
            aground_interval: wilson(aground, runs).unwrap_or([0.0, 1.0]),
            vessels_aground,
            aground_bound: bound(found.len()),
            aground_bound_by_vessels: bound(vessels),
            below_margin: count(&|run| run.passage.clearance_m < safety.margin_m),
            ends: found.iter().map(|run| run.ends[0]).sum(),
            ends_astray: found.iter().map(|run| run.ends[1]).sum(),
            tolerance_used: self.used(&self.nominal.ends).into_iter().fold(0.0, f64::max),
            proved_s: self.legs.iter().map(|leg| prepared.legs[*leg].seconds(rate_hz)).sum(),
            sailed_s: self.nominal.samples.len() as f64 / rate_hz,
            sailed_quantiles_s: [0.0, 0.5, 1.0].map(|q| quantile(&seconds, q).unwrap_or(0.0)),
            rounds: u64::from(self.round),
            left_area: count(&|run| run.passage.left_area),
            clearance_quantiles_m: [0.0, 0.05, 0.5].map(|q| quantile(&least, q).unwrap_or(0.0)),
            aground_open_loop: count(&|run| run.open_loop.clearance_m <= 0.0),
        };
        check.with_faults()
    }
}

impl Check {
    /// Adds its faults in words.
    fn with_faults(mut self) -> Self {
        let percent = |share: f64| format!("{:.1}", 100.0 * share);
        let mut faults = Vec::new();
        if !self.clear {
            faults.push("the nominal track touches an obstacle".to_owned());
        } else if self.shortfall_m > 0.0 {
            faults.push(format!("the nominal track is {:.0} m short of its margin", self.shortfall_m.ceil()));
        }
        if self.aground > 0 {
            let [low, high] = self.aground_interval.map(percent);
            let (share, runs) = (percent(self.aground as f64 / self.runs as f64), self.runs);
            faults.push(format!("{} of {runs} runs aground ({share} %, {low} to {high} %)", self.aground));
        }
        if self.below_margin > self.aground {
            let (nearer, runs) = (self.below_margin - self.aground, self.runs);
            faults.push(format!("{nearer} of {runs} runs afloat nearer than the margin"));
        }
        if self.ends_astray > 0 {
            let (astray, ends) = (self.ends_astray, self.ends);
            faults.push(format!("{astray} of {ends} ends of legs beyond their tolerance"));
        }
        if (self.sailed_s - self.proved_s).abs() > LONGER * self.proved_s {
            let (sailed, proved) = (self.sailed_s, self.proved_s);
            faults.push(format!("simulated in {sailed:.0} s, proved to take {proved:.0} s"));
        }
        (self.safe, self.faults) = (faults.is_empty(), faults);
        self
    }
}
