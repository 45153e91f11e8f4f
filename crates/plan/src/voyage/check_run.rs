//! Simulations of the whole plan in a check.

use std::cell::RefCell;

use rayon::prelude::*;
use refusal::Invalid;
use ship::engine::{Pose, Ship, Streams};

use super::clearance::{Clearance, Cleared};
use super::error::{Search, VoyageError, parameters_in_words};
use super::prepared::Prepared;
use crate::leg::turned_back;
use crate::simulate::simulate_with_ends;
use crate::{Astray, Autopilot, End, Fix, Leg, Passing, Sailed, SampledVessel, Used, simulate_legs};

/// Share of the ends of legs that noise may leave beyond a tolerance.
const ASTRAY_BY_NOISE: f64 = 0.01;

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

/// A vessel in a current, to be simulated over the whole plan.
#[derive(Clone, Debug)]
pub(super) struct Vessel {
    pub parameters: Vec<f64>,
    /// Unknown current, north and east \[m/s\].
    pub unknown_m_s: [f64; 2],
    /// Whether its track is kept for drawing.
    pub is_drawn: bool,
    /// Which noise its sensors have, and which changes of current and wind it meets.
    pub noise: u32,
    /// Whether it comes from a search, which needs the clearance of every leg and no run without corrections.
    pub is_searched: bool,
    /// Whether it sails the abort tracks, too.
    pub aborts: bool,
}

/// A run of a check.
pub(super) struct CheckedRun {
    pub vessel: Vessel,
    /// Over all legs.
    pub passage: Cleared,
    /// Clearance of every leg; exact only below the margin and the least one so far, unless it was searched \[m\].
    pub clearances_m: Vec<f64>,
    /// The same of a searched run, interpolated between cells \[m\].
    pub between_cells_m: Vec<f64>,
    /// Whether it goes aground without corrections.
    pub is_aground_open_loop: bool,
    /// Ends of legs.
    pub ends: Vec<End>,
    /// The used part of the tolerance at each.
    pub used: Vec<Used>,
    pub seconds: f64,
    pub track: Option<Vec<Fix>>,
    /// Clearance of the abort track of every step, exact only below the margin, unless it was searched \[m\]; none where it
    /// does not sail them.
    aborts_m: Vec<f64>,
}

/// What became of vessels on an abort track.
#[derive(Clone, Copy)]
pub(super) struct Aborted {
    pub vessels: u64,
    /// Least distance of any of them from an obstacle \[m\].
    pub clearance_m: f64,
    pub aground: u64,
    /// Those that came nearer than the margin.
    pub below_margin: u64,
}

impl Aborted {
    pub fn new(clearance: &Clearance) -> Self {
        Self { vessels: 0, clearance_m: clearance.sight_m, aground: 0, below_margin: 0 }
    }

    /// A vessel whose clearance is exact only below the margin, unless it `is_exact`.
    pub fn add(&mut self, clearance_m: f64, margin_m: f64, is_exact: bool) {
        self.vessels += 1;
        if is_exact || clearance_m < margin_m {
            self.clearance_m = self.clearance_m.min(clearance_m);
        }
        self.aground += u64::from(clearance_m <= 0.0);
        self.below_margin += u64::from(clearance_m < margin_m);
    }
}

impl Checking<'_> {
    pub(super) fn prepared(&self) -> &Prepared {
        self.script.prepared
    }

    /// The share of the ends of legs that may be beyond a tolerance: none, unless sensors are noisy, or current or wind change.
    pub(super) fn tolerated_astray(&self) -> f64 {
        let task = &self.prepared().brief.task;
        if task.sensors.are_exact() && task.changes.are_none() { 0.0 } else { ASTRAY_BY_NOISE }
    }

    /// Whether more ends of legs than that are beyond a tolerance.
    pub(super) fn are_too_many_astray(&self, runs: &[&CheckedRun]) -> bool {
        let astray: u64 = runs.iter().map(|run| run.ends_astray()).sum();
        let ends: usize = runs.iter().map(|run| run.ends.len()).sum();
        astray as f64 > self.tolerated_astray() * ends as f64
    }

    /// A run of every one of `vessels`, in their order.
    pub(super) fn all(&self, vessels: Vec<Vessel>, search: &Search) -> Result<Vec<CheckedRun>, VoyageError> {
        let one = |vessel: Vessel| {
            if !(search.keep_going)() {
                return Err(VoyageError::OutOfTime("the check of the plan"));
            }
            let words = parameters_in_words(&self.prepared().brief.vessel, &vessel.parameters);
            // A vessel that cannot be simulated is not the fault of a file.
            let named = |e: Invalid| Invalid { thing: format!("{} with {words}", e.thing), ..e };
            self.run(vessel).map_err(|refused| VoyageError::NoAnswer(named(refused)))
        };
        let all: Vec<_> = vessels.into_par_iter().map(one).collect();
        all.into_iter().collect()
    }

    /// Simulates a vessel.
    pub(super) fn run(&self, vessel: Vessel) -> Result<CheckedRun, Invalid> {
        let (clearance, brief) = (self.clearance, &self.prepared().brief);
        let open = if vessel.is_searched { clearance.open_to_compare() } else { clearance.open() };
        let margin_m = brief.task.safety.margin_m;
        let mut abort = clearance.open();
        abort.clearance_m = if vessel.is_searched { clearance.sight_m } else { margin_m };
        let (mut passages, mut aborts) = (vec![open; self.legs.len()], vec![abort; self.legs.len()]);
        let (mut samples, mut leg) = (0_u64, 0);
        // Some vessels take longer than the nominal one.
        let capacity = self.nominal.samples.len() * 9 / 8;
        let mut track = vessel.is_drawn.then(|| Vec::with_capacity(capacity));
        let noise = self.noise(&vessel);
        let who = (&vessel.parameters[..], vessel.unknown_m_s, vessel.aborts);
        let ends = self.script.simulate(who, noise, |sample, is_abort| {
            if is_abort {
                return clearance.add(&mut aborts[sample.leg], sample.pose, false);
            }
            if sample.leg > leg {
                if !vessel.is_searched {
                    // Distances beyond the margin and the least one so far are irrelevant.
                    passages[sample.leg].clearance_m = passages[leg].clearance_m.max(margin_m);
                }
                leg = sample.leg;
            }
            clearance.add(&mut passages[sample.leg], sample.pose, sample.informative);
            samples += 1;
            if let Some(track) = &mut track {
                track.push(Fix { leg: sample.leg, pose: sample.pose });
            }
        })?;
        Ok(CheckedRun {
            passage: passages.iter().fold(clearance.open(), |a, b| a.and(b)),
            clearances_m: passages.iter().map(|passage| passage.clearance_m).collect(),
            between_cells_m: passages.iter().filter_map(|passage| passage.between_cells_m).collect(),
            is_aground_open_loop: !vessel.is_searched && self.is_aground_open_loop(&vessel),
            used: self.used(&ends),
            aborts_m: aborts.iter().filter(|_| vessel.aborts).map(|passage| passage.clearance_m).collect(),
            ends,
            seconds: samples as f64 / brief.vessel.sample_rate_hz,
            track,
            vessel,
        })
    }

    fn noise(&self, vessel: &Vessel) -> Option<RunNoise> {
        let kind = if vessel.is_searched { "searched" } else { "checked" };
        Some(RunNoise { kind, round: self.round, run: vessel.noise })
    }

    fn is_aground_open_loop(&self, vessel: &Vessel) -> bool {
        let mut open_loop = self.clearance.open();
        // Only running aground matters.
        open_loop.clearance_m = f64::MIN_POSITIVE;
        let noise = self.noise(vessel);
        self.script.repeat(self.nominal, &vessel.parameters, vessel.unknown_m_s, noise, |sample| {
            self.clearance.add(&mut open_loop, sample.pose, sample.informative);
            open_loop.clearance_m > 0.0
        });
        open_loop.clearance_m <= 0.0
    }

    /// How far off a step ends, with signs, in tolerances: north, east, heading, surge, sway, yaw rate.
    pub(super) fn off(&self, step: usize, end: End) -> [f64; 6] {
        let (repertoire, (layer, node)) = (self.prepared().repertoire(), self.end_of(step));
        let (vessel, heading_rad, speed_m_s) = repertoire.at_node(layer, node, end);
        repertoire.approach.tolerance.off(&vessel, heading_rad, speed_m_s)
    }

    /// The layer and the node (north, east) that a step ends at.
    fn end_of(&self, step: usize) -> (usize, [f64; 2]) {
        let (node, leg) = self.script.legs[step];
        let [north, east] = self.prepared().grid.displacement(leg.di, leg.dj);
        (leg.to, [node[0] + north, node[1] + east])
    }

    /// The used fractions of the tolerance at the end of every step.
    pub(super) fn used(&self, ends: &[End]) -> Vec<Used> {
        let repertoire = self.prepared().repertoire();
        let tolerance = repertoire.approach.tolerance;
        let used = |(step, end): (usize, &End)| {
            let (layer, node) = self.end_of(step);
            repertoire.used_at(&tolerance, layer, node, *end)
        };
        ends.iter().enumerate().map(used).collect()
    }
}

/// What is kept of a drawn run.
pub(super) struct Drawn {
    pub passage: Cleared,
    pub is_aground_open_loop: bool,
    /// Ends of legs, and those beyond a tolerance.
    pub ends: [u64; 2],
    /// The largest used fractions at any of them.
    pub used: Used,
    pub seconds: f64,
    pub track: Option<Vec<Fix>>,
}

impl From<CheckedRun> for Drawn {
    fn from(run: CheckedRun) -> Self {
        let ends = [run.ends.len() as u64, run.ends_astray()];
        let used = run.most_used();
        let CheckedRun { passage, is_aground_open_loop, seconds, track, .. } = run;
        Self { passage, is_aground_open_loop, ends, used, seconds, track }
    }
}

impl CheckedRun {
    pub(super) fn ends_astray(&self) -> u64 {
        self.used.iter().filter(|used| used.part() > 1.0).count() as u64
    }

    /// Adds what became of it on the abort tracks.
    pub(super) fn abort(&self, aborted: &mut [Aborted], margin_m: f64) {
        let is_exact = self.vessel.is_searched;
        aborted
            .iter_mut()
            .zip(&self.aborts_m)
            .for_each(|(all, least_m)| all.add(*least_m, margin_m, is_exact));
    }

    /// The largest used fractions at the end of any step.
    pub(super) fn most_used(&self) -> Used {
        self.used.iter().copied().fold(Used::NONE, Used::or_more)
    }

    /// Whether a step began within its tolerance.
    pub(super) fn began_well(&self, step: usize) -> bool {
        step == 0 || self.used[step - 1].part() <= 1.0
    }

    /// The steps that began within the tolerance and violated the margin or, `if_astray`, the tolerance, each with its vessel.
    pub(super) fn counter_examples(&self, checking: &Checking, astray: bool) -> Vec<(usize, SampledVessel)> {
        let margin_m = checking.prepared().brief.task.safety.margin_m;
        let failed = |step: &usize| {
            self.clearances_m[*step] < margin_m
                || (astray && self.used[*step].part() > 1.0 && self.began_well(*step))
        };
        let failures = (0..self.used.len()).filter(failed);
        failures.map(|step| (step, self.sampled_vessel(checking, step))).collect()
    }

    /// The vessel of a step, with its offset at the beginning.
    pub(super) fn sampled_vessel(&self, checking: &Checking, step: usize) -> SampledVessel {
        let (node, leg) = checking.script.legs[step];
        let grid = &checking.prepared().grid;
        let (level, mode) = grid.level_and_mode(leg.from);
        let (heading, speed) = (grid.heading_rad(level), grid.modes[mode].speed_m_s);
        let exact = (checking.script.start, [speed, 0.0, 0.0]);
        let (pose, [u, v, r]) = if step == 0 { exact } else { self.ends[step - 1] };
        let Astray { pose: Pose { x, y, psi }, .. } = Astray::of(pose, [u, v, r], node);
        let [along, across] = turned_back([x, y], heading);
        SampledVessel {
            parameters: self.vessel.parameters.clone(),
            current_m_s: turned_back(self.vessel.unknown_m_s, heading),
            off: [along, across, crate::leg::wrap(psi - heading)],
            motion: [u - speed, v, r],
        }
    }
}

/// Legs from their nodes (north, east), in order.
pub(super) type Legs<'a> = Vec<([f64; 2], &'a Leg)>;

/// A plan to be sailed.
pub(super) struct Script<'a> {
    pub prepared: &'a Prepared,
    pub legs: Legs<'a>,
    /// Of every step: the legs that she leaves its end by if it fails.
    pub aborts: Vec<Legs<'a>>,
    pub start: Pose,
    pub speed_m_s: f64,
}

/// The noise of a vessel's sensors, and of the changes of current and wind.
#[derive(Clone, Copy)]
pub(super) struct RunNoise {
    /// What it is simulated for.
    pub kind: &'static str,
    /// In which round.
    pub round: u32,
    /// Its number.
    pub run: u32,
}

impl RunNoise {
    fn streams(&self, seed: u64, of: &str) -> Streams {
        Streams::new(seed, &format!("{}-{of}-{}", self.kind, self.round))
    }
}

impl Script<'_> {
    /// Simulates a vessel with `parameters` in the known current and `unknown` (north, east), on abort tracks, too, if it `aborts`;
    /// calls `record` with every sample, and whether it is on the abort track of its leg, whose last place it has, too. Without
    /// `noise` sensors are exact, and current and wind do not change.
    pub(super) fn simulate(
        &self,
        (parameters, unknown, aborts): (&[f64], [f64; 2], bool),
        noise: Option<RunNoise>,
        record: impl FnMut(Passing, bool),
    ) -> Result<Vec<End>, Invalid> {
        let Prepared { brief, pieces, mirror, .. } = self.prepared;
        let mut ship = self.ship(parameters, unknown, noise);
        let mut autopilot = Autopilot::new(&brief.vessel, &brief.vessel.nominal, brief.task.handling);
        if let Some(noise) = noise {
            let streams = noise.streams(brief.seed, "sensors");
            autopilot = autopilot.with_sensors(brief.task.sensors, streams, noise.run);
        }
        autopilot.known_current_m_s = brief.task.known_current_m_s;
        let (mirror, record) = (mirror.as_deref().unwrap_or_default(), RefCell::new(record));
        let passed = |passing: Passing| (record.borrow_mut())(passing, false);
        let legs = self.legs.iter().copied();
        let pieces = (&pieces[..], mirror);
        let ends =
            simulate_with_ends(legs, pieces, &mut ship, &mut autopilot, passed, |leg, ship, autopilot| {
                let legs = Some(&self.aborts[leg]).filter(|legs| aborts && !legs.is_empty());
                let Some(legs) = legs else { return Ok(()) };
                let (mut ship, mut autopilot) = (ship.clone(), autopilot.clone());
                let mut record = |passing: Passing| (record.borrow_mut())(Passing { leg, ..passing }, true);
                let legs = legs.iter().copied();
                simulate_legs(legs, pieces.0, mirror, &mut ship, &mut autopilot, &mut record)?;
                record(Passing { leg, informative: false, pose: ship.pose, state: ship.state, inputs: &[] });
                Ok(())
            });
        Ok(ends?)
    }

    /// The trajectory of the nominal vessel without unknown current, and that of its abort tracks: of every step the poses up
    /// to its end.
    pub(super) fn nominal(&self) -> Result<(Sailed, Vec<Vec<Pose>>), Invalid> {
        let (mut samples, mut aborts) = (Vec::new(), vec![Vec::new(); self.legs.len()]);
        let nominal = &self.prepared.brief.vessel.nominal;
        let ends = self.simulate((nominal, [0.0; 2], true), None, |passing, is_abort| match is_abort {
            true => aborts[passing.leg].push(passing.pose),
            false => samples.push(passing.into()),
        })?;
        Ok((Sailed { samples, ends }, aborts))
    }

    /// Repeats the inputs of a track, sample by sample, without corrections: calls `record` with every sample
    /// until it returns false. `noise` as in [`Self::simulate`].
    fn repeat(
        &self,
        nominal: &Sailed,
        parameters: &[f64],
        unknown: [f64; 2],
        noise: Option<RunNoise>,
        mut record: impl FnMut(Passing) -> bool,
    ) {
        let mut ship = self.ship(parameters, unknown, noise);
        for sample in &nominal.samples {
            let (pose, state, inputs) = (ship.pose, ship.state, &sample.inputs[..]);
            if !record(Passing { leg: sample.leg, informative: sample.informative, pose, state, inputs }) {
                return;
            }
            ship.step(inputs);
        }
    }

    fn ship<'s>(&'s self, parameters: &[f64], unknown: [f64; 2], noise: Option<RunNoise>) -> Ship<'s> {
        let brief = &self.prepared.brief;
        let mut ship = Ship::new(&brief.vessel, parameters, self.start, self.speed_m_s);
        ship.current_m_s = [0, 1].map(|d| brief.task.known_current_m_s[d] + unknown[d]);
        ship.changing = noise.and_then(|noise| {
            let streams = noise.streams(brief.seed, "changes");
            brief.task.changes.of_run(streams, noise.run, brief.vessel.sample_rate_hz)
        });
        ship
    }
}
