//! The check of a plan in continuous space: clearance of the hull from charted obstacles and settling at the
//! ends of legs, by the nominal model, by the worst vessels that a search finds, and by drawn ones.

use std::collections::BTreeSet;

use numerics::statistics::{quantile, sorted, wilson};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::check_run::{Aborted, CheckedRun, Checking, Drawn, Vessel};
use super::clearance::cells_around;
use super::error::{Footing, Search, VoyageError};
use super::prepared::Prepared;
use super::settled_legs::SettledLeg;
use super::solve::Moves;
use super::task::{Brief, ErrorsFrom, Secondary, key_of};
use super::worst::{Searched, WorstVessels};
use crate::lattice::{Demand, Lattice};
use crate::{Fix, Sample, SampledVessel, Used};

/// Tracks that are kept for drawing.
const TRACKS: u32 = 200;
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
    /// Bound on the errors of all parameters jointly, in standard errors of the model; absent where each is bounded alone.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub standard_errors: Option<f64>,
    /// What states those standard errors; absent with them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub errors_from: Option<ErrorsFrom>,
    /// Of the currents and parameters.
    pub seed: u64,
    /// Simulations of the whole plan, each with a constant current and a vessel of its own, whose parameters are even within
    /// that bound.
    pub runs: u64,
    /// Of which touched an obstacle, or went where the chart was not read.
    pub aground: u64,
    /// The share of them that this leaves possible, Wilson's 95 %.
    pub aground_interval: [f64; 2],
    /// Going aground is less probable than this, 95 % confidence, for a vessel and a current drawn like these. None where a
    /// run went aground.
    pub aground_bound: Option<f64>,
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
    /// The worst vessels and currents within those bounds that a search found, apart from the drawn ones; absent where only
    /// the nominal vessel in the known current is possible.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub worst: Option<WorstVessels>,
}

/// The result of a check.
pub(super) struct Checked {
    pub check: Check,
    /// Tracks for drawing.
    pub tracks: Vec<Vec<Fix>>,
    /// Steps that violated a margin or a tolerance, each with the vessel and its initial offset.
    pub counter_examples: Vec<(usize, SampledVessel)>,
    /// What became of all vessels on the abort track of every step.
    pub aborted: Vec<Aborted>,
}

impl Prepared {
    /// The number of runs of a check in this round.
    pub(super) fn runs(&self, round: u32) -> u32 {
        let safety = &self.brief.task.safety;
        match (safety.runs, safety.aground_probability) {
            (Some(runs), None) => runs,
            (runs, probability) => {
                let needed = needed(round, probability.unwrap_or(USUAL_PROBABILITY));
                runs.map_or(needed, |runs| runs.max(needed))
            }
        }
    }
}

/// The default bound on the probability of running aground.
pub(super) const USUAL_PROBABILITY: f64 = 0.01;

/// Runs without any aground that bound the probability of it by `p`.
fn needed(round: u32, p: f64) -> u32 {
    (libm::log(doubt(round)) / libm::log1p(-p)).ceil().max(1.0) as u32
}

/// Probability that the bound of a round does not hold: halved from round to round, so that the sum is bounded.
fn doubt(round: u32) -> f64 {
    DOUBT * 0.5_f64.powi(round as i32)
}

impl Checking<'_> {
    /// Searches the worst vessels, then simulates the script with drawn parameters and in drawn currents; `concurrent`
    /// is executed along with the last runs, if all of them are simulated.
    pub(super) fn check<T: Send>(
        &self,
        search: &Search,
        concurrent: impl FnOnce() -> T + Send,
    ) -> Result<(Checked, Option<T>), VoyageError> {
        let worst = self.worst(search)?;
        let mut aborted = vec![Aborted::new(self.clearance); self.legs.len()];
        let margin_m = self.prepared().brief.task.safety.margin_m;
        let mut abort = |run: &CheckedRun| run.abort(&mut aborted, margin_m);
        worst.runs().for_each(&mut abort);
        let mut counter_examples = worst.counter_examples(self);
        let runs = self.prepared().runs(self.round);
        let (mut drawn, mut next, mut concurrent, mut aside) = (Vec::new(), 0, Some(concurrent), None);
        while next < runs && (counter_examples.is_empty() || self.is_last) {
            let some = next..(next + FIRST_RUNS.max(next * FIRST_RUNS)).min(runs);
            let simulate = || self.all(some.clone().map(|run| self.drawn(run)).collect(), search);
            let new = match concurrent.take_if(|_| some.end == runs) {
                Some(follow) => {
                    let (new, followed) = rayon::join(simulate, follow);
                    aside = Some(followed);
                    new?
                }
                None => simulate()?,
            };
            let if_astray = self.are_too_many_astray(&new.iter().collect::<Vec<_>>());
            counter_examples.extend(new.iter().flat_map(|run| run.counter_examples(self, if_astray)));
            new.iter().for_each(&mut abort);
            drawn.extend(new.into_iter().map(Drawn::from));
            next = some.end;
        }
        let check = self.judged(&drawn, &worst);
        let tracks = drawn.into_iter().filter_map(|run| run.track).collect();
        // The counter-examples of the last round are not used.
        let counter_examples = if self.is_last { Vec::new() } else { counter_examples };
        Ok((Checked { check, tracks, counter_examples, aborted }, aside))
    }

    fn drawn(&self, run: u32) -> Vessel {
        let (brief, round) = (&self.prepared().brief, self.round);
        // Of many, as many sail the abort tracks as exclude the usual probability of running aground there.
        Vessel {
            parameters: brief.drawn(&format!("checked-parameters-{round}"), run),
            unknown_m_s: brief.current(&format!("unknown-current-{round}"), run),
            is_drawn: run < TRACKS,
            noise: run,
            is_searched: false,
            aborts: run < needed(round, USUAL_PROBABILITY),
        }
    }

    fn judged(&self, drawn: &[Drawn], worst: &Searched) -> Check {
        let (prepared, clearance) = (self.prepared(), self.clearance);
        let safety = prepared.brief.task.safety;
        let count = |is: &dyn Fn(&Drawn) -> bool| drawn.iter().filter(|run| is(run)).count() as u64;
        let least = sorted(drawn.iter().map(|run| Some(run.passage.clearance_m)));
        let seconds = sorted(drawn.iter().map(|run| Some(run.seconds)));
        let mut cleared = clearance.open();
        self.nominal.samples.iter().for_each(|s| clearance.add(&mut cleared, s.pose, s.informative));
        let rate_hz = prepared.brief.vessel.sample_rate_hz;
        let (runs, is_aground) = (drawn.len() as u64, |run: &Drawn| run.passage.clearance_m <= 0.0);
        let aground = count(&is_aground);
        let bound = || 1.0 - libm::exp(libm::log(doubt(self.round)) / drawn.len() as f64);
        let check = Check {
            safe: false,
            faults: Vec::new(),
            clearance_m: cleared.clearance_m,
            clear: cleared.clearance_m > 0.0,
            margin_m: safety.margin_m,
            shortfall_m: (safety.margin_m - cleared.clearance_m).max(0.0),
            sight_m: clearance.sight_m,
            unknown_current_m_s: safety.unknown_current_m_s,
            parameter_error: safety.parameter_error,
            standard_errors: safety.standard_errors,
            errors_from: prepared.brief.task.errors_from,
            seed: prepared.brief.seed,
            runs,
            aground,
            aground_interval: wilson(aground, runs).unwrap_or([0.0, 1.0]),
            aground_bound: (aground == 0 && !drawn.is_empty()).then(bound),
            below_margin: count(&|run| run.passage.clearance_m < safety.margin_m),
            ends: drawn.iter().map(|run| run.ends[0]).sum(),
            ends_astray: drawn.iter().map(|run| run.ends[1]).sum(),
            tolerance_used: self.used(&self.nominal.ends).iter().map(Used::part).fold(0.0, f64::max),
            proved_s: self.legs.iter().map(|leg| prepared.legs[*leg].seconds(rate_hz)).sum(),
            sailed_s: self.nominal.samples.len() as f64 / rate_hz,
            sailed_quantiles_s: [0.0, 0.5, 1.0].map(|q| quantile(&seconds, q).unwrap_or(0.0)),
            rounds: u64::from(self.round),
            left_area: count(&|run| run.passage.left_area),
            clearance_quantiles_m: [0.0, 0.05, 0.5].map(|q| quantile(&least, q).unwrap_or(0.0)),
            aground_open_loop: count(&|run| run.is_aground_open_loop),
            worst: worst.summary(self),
        };
        let used = drawn.iter().map(|run| run.used).fold(worst.most_used(), Used::or_more);
        check.with_faults(self.tolerated_astray(), used)
    }
}

impl Check {
    /// What [`Self::standard_errors`] counts, in words.
    pub fn errors_of(&self) -> &'static str {
        match self.errors_from {
            Some(ErrorsFrom::Priors) => "standard deviations of the priors",
            _ => "standard errors of the model",
        }
    }

    /// Adds its faults in words; a share of the ends of legs may be astray, and `used` is most of all tolerances.
    fn with_faults(mut self, astray: f64, used: Used) -> Self {
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
        let are_astray = |astray_ends: u64, ends: u64| astray_ends as f64 > astray * ends as f64;
        let drawn_astray = are_astray(self.ends_astray, self.ends);
        if drawn_astray {
            let (astray, ends) = (self.ends_astray, self.ends);
            faults.push(format!("{astray} of {ends} ends of legs beyond their tolerance"));
        }
        faults.extend(self.worst.iter().flat_map(|worst| worst.faults(astray, key_of(self.standard_errors))));
        let is_astray = |worst: &WorstVessels| are_astray(worst.ends_astray, worst.ends);
        if drawn_astray || self.worst.as_ref().is_some_and(is_astray) {
            faults.push(format!("at the ends of legs {used}"));
        }
        if (self.sailed_s - self.proved_s).abs() > LONGER * self.proved_s {
            let (sailed, proved) = (self.sailed_s, self.proved_s);
            faults.push(format!("simulated in {sailed:.0} s, proved to take {proved:.0} s"));
        }
        (self.safe, self.faults) = (faults.is_empty(), faults);
        self
    }
}

/// Approximate bytes of inputs, threads and output.
const READ_BYTES: u128 = 28 << 20;
const WRITTEN_BYTES: u128 = 12 << 20;

/// Most uses of a maneuver that are budgeted for before the search, which refuses more.
const MOST_USES: u32 = 1000;

impl Brief {
    /// Refuses a lattice and a raster that exceed the memory whatever the charts have.
    ///
    /// # Errors
    /// Such a task; as [`Prepared::new`], of its area.
    pub fn check_size(&self, memory_bytes: u64) -> Result<(), VoyageError> {
        let task = &self.task;
        let grid = task.grid(&self.vessel, task.laid(&task.area.plane()?)?);
        let lattice = Lattice { nx: grid.nx, ny: grid.ny, layers: grid.layers() };
        let least = Footing {
            lattice: Demand::new(lattice, &[]),
            cells: cells_around(&task.raster(&grid), task.safety.margin_m),
            clearance_cells: 0,
            other: 0,
            check: 0,
        };
        match least.bytes() > memory_bytes.into() {
            true => Err(VoyageError::TooLarge(least)),
            false => Ok(()),
        }
    }
}

/// Refuses a footing that exceeds `memory_bytes`.
fn fits(footing: Footing, memory_bytes: u64) -> Result<(), VoyageError> {
    if footing.bytes() > u128::from(memory_bytes) { Err(VoyageError::TooLarge(footing)) } else { Ok(()) }
}

impl Prepared {
    /// Refuses rasters that exceed the memory, regardless of legs.
    pub(super) fn check_rasters(&self, search: &Search) -> Result<(), VoyageError> {
        fits(self.footing(&[])?, search.options.memory_bytes)
    }

    /// Refuses rasters and legs that exceed the memory; else returns the search with the remaining memory.
    pub(super) fn within<'a>(&self, moves: &Moves, search: &Search<'a>) -> Result<Search<'a>, VoyageError> {
        let footing = self.footing(&moves.actions)?;
        fits(footing, search.options.memory_bytes)?;
        Ok(search.reserving(footing.kept_bytes()))
    }

    /// Refuses a plan whose check exceeds the memory; else returns a concurrent search with the remaining memory.
    pub(super) fn within_check<'a>(
        &self,
        moves: &Moves,
        (round, samples): (u32, usize),
        search: &Search<'a>,
    ) -> Result<Search<'a>, VoyageError> {
        let footing = Footing { check: self.check_bytes(round, samples), ..self.footing(&moves.actions)? };
        fits(footing, search.options.memory_bytes)?;
        Ok(search.reserving(footing.kept_bytes() + footing.lattice.kept_bytes() + footing.check))
    }

    fn footing(&self, actions: &[crate::lattice::Action]) -> Result<Footing, VoyageError> {
        let (task, grid) = (&self.brief.task, &self.grid);
        let raster = task.raster(grid);
        let layers =
            self.obstacle_kinds().0.len().max(1) + usize::from(task.cost.secondary == Secondary::Clearance);
        let masks =
            usize::from(!task.area.corners.is_empty()) + task.speed_limits.len() + self.directions().len();
        let around = cells_around(&raster, task.safety.margin_m);
        let read = READ_BYTES.max(self.brief.chart_bytes.into());
        let legs = self.legs.iter().map(|leg| self.bytes_of(leg)).sum::<u128>();
        Ok(Footing {
            lattice: self.demand(actions),
            cells: layers as u128 * around + (masks * raster.nx * raster.ny) as u128,
            clearance_cells: self.clearance_cells()?,
            // The chart was in memory as it was read, too, except for the cells of its grids.
            other: read + 2 * u128::from(self.chart.bytes()) + u128::from(self.chart.grid_bytes()) + legs,
            check: self.check_bytes(1, self.least_samples()),
        })
    }

    fn demand(&self, actions: &[crate::lattice::Action]) -> Demand {
        let grid = &self.grid;
        Demand::new(Lattice { nx: grid.nx, ny: grid.ny, layers: grid.layers() }, actions)
    }

    /// Bytes of a round's plan while the next one is searched: its problem, and its legs that are simulated again.
    pub(super) fn last_bytes(&self, moves: &Moves, counter_examples: &[(usize, SampledVessel)]) -> u128 {
        let anew: BTreeSet<usize> = counter_examples.iter().map(|(leg, _)| self.legs[*leg].group).collect();
        let legs = self.legs.iter().filter(|leg| anew.contains(&leg.group));
        self.demand(&moves.actions).kept_bytes() + legs.map(|leg| self.bytes_of(leg)).sum::<u128>()
    }

    /// Bytes of a simulated leg.
    fn bytes_of(&self, leg: &SettledLeg) -> u128 {
        let sample = size_of::<Sample>() + 8 * self.brief.vessel.model.inputs;
        (leg.sailed.samples.len() * sample + size_of_val(leg.footprint.runs())) as u128
    }

    /// Bytes of a check's runs, of the tracks that are kept of them and of the nominal one.
    fn check_bytes(&self, round: u32, samples: usize) -> u128 {
        let runs = self.runs(round);
        let sample = size_of::<Sample>() + 8 * self.brief.vessel.model.inputs;
        let tracks = runs.min(TRACKS) as usize * size_of::<Fix>() * 9 / 8;
        WRITTEN_BYTES + (runs as usize * size_of::<Drawn>()) as u128 + (samples * (tracks + sample)) as u128
    }

    /// Samples of all maneuvers, each from the fastest heading: any plan has more.
    fn least_samples(&self) -> usize {
        let rate_hz = self.brief.vessel.sample_rate_hz;
        let pieces = self.wanted.iter().enumerate();
        let seconds =
            pieces.map(|(piece, wanted)| f64::from(wanted.count.min(MOST_USES)) * self.shortest_leg_s(piece));
        seconds.filter(|s| s.is_finite()).map(|s| (s * rate_hz) as usize).sum()
    }
}
