//! If it fails now: from the end of every leg an abort track onto water where the ship may wait, and how she drifts with her engine
//! stopped from anywhere on it.

use std::f64::consts::TAU;

use rayon::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use ship::engine::{DIVERGED, Pose as AtSea, Ship, Streams};

use super::check_run::{Aborted, Legs};
use super::clearance::Clearance;
use super::error::{Search, VoyageError};
use super::prepared::Prepared;
use super::solve::Solved;
use super::task::Brief;
use super::waters::{Waiting, WaitingPlace};
use crate::handling::idle;
use crate::lattice::{Limit, Pose, Step};
use crate::{Sailed, Sample, SampledVessel};

/// Moments of a leg at which the engine is stopped, evenly spread.
const STOPS: usize = 8;

/// From the end of a leg to the nearest place where she may wait: a charted anchorage if that takes at most ten minutes longer,
/// else water with depth and room.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct AbortTrack {
    /// What the place is.
    pub kind: WaitingPlace,
    /// Longitude of the place.
    pub longitude_deg: f64,
    /// Latitude of the place.
    pub latitude_deg: f64,
    /// The depth that is charted there; absent where none is \[m\].
    pub depth_m: Option<f64>,
    /// So far around it her hull keeps its margin \[m\].
    pub room_m: f64,
    /// True bearing of the place from where the leg ends; absent where it is the same.
    pub towards_deg: Option<f64>,
    /// Distance of the place from there \[m\].
    pub distance_m: f64,
    /// Time of the nominal vessel along the track \[s\].
    pub duration_s: f64,
    /// Basic moves; none where she waits at the end of the leg.
    pub moves: Vec<AbortMove>,
    /// Vessels of the check that sailed it after the legs before: the nominal one, the searched ones, and as many of the drawn
    /// ones as exclude that one of a hundred runs aground, with 95 % confidence; 0 without moves.
    pub vessels: u64,
    /// Of which touched an obstacle on it.
    pub aground: u64,
    /// Least distance from an obstacle on it, of the nominal and the searched ones; absent without moves \[m\].
    pub clearance_m: Option<f64>,
}

/// A move of an abort track, and the pose of the lattice where it ends.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct AbortMove {
    /// Name of the basic move.
    pub action: String,
    /// Column, eastward.
    pub i: u64,
    /// Row, northward.
    pub j: u64,
    /// Heading level, counter-clockwise from east.
    pub h: u64,
    /// Speed mode.
    pub mode: String,
}

/// With her engine stopped and her rudder amidships, somewhere on a leg: the nominal vessel, and the sampled ones in gusts and in the
/// strongest unknown current, each towards another direction.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LegDrift {
    /// For how long they drift \[s\].
    pub lasts_s: f64,
    /// Vessels, each from several moments of the leg.
    pub drifted: u64,
    /// Of which touch an obstacle.
    pub aground: u64,
    /// Least distance of any of them from an obstacle; 0 aground \[m\].
    pub clearance_m: f64,
    /// When the worst of them is that near, after the engine stops: of those aground the first \[s\].
    pub nearest_s: f64,
    /// When in the trial its engine stops \[s\].
    pub stopped_s: f64,
}

/// What becomes of the ship if it fails on a leg.
#[derive(Clone, Debug)]
pub struct LegFailure {
    /// Her abort track, and east and north of the nominal vessel on it \[m\]; else why there is none.
    pub abort: Result<(AbortTrack, Vec<[f64; 2]>), String>,
    /// How she drifts.
    pub drift: LegDrift,
}

/// A drift so far: the worse, the earlier aground, else the nearer.
#[derive(Clone, Copy)]
struct Drifted {
    clearance_m: f64,
    nearest_s: f64,
    stopped_s: f64,
}

impl Drifted {
    fn worse(self, other: Self) -> Self {
        let badness = |one: &Self| (one.clearance_m, if one.clearance_m > 0.0 { 0.0 } else { one.nearest_s });
        if badness(&other) < badness(&self) { other } else { self }
    }
}

/// The ways out of a plan, before they are sailed.
pub(super) struct WaysOfPlan {
    waiting: Waiting,
    /// The moves from the end of every step; else why there are none.
    moves: Vec<Result<Vec<Step>, String>>,
}

impl Prepared {
    /// The ways out from all steps of a plan.
    pub(super) fn ways_of(&self, solved: &Solved, search: &Search) -> Result<WaysOfPlan, VoyageError> {
        let waiting = self.waiting(search.keep_going)?;
        let left = self.within(&solved.moves, search)?;
        let ways = match self.ways_out(&solved.problem, &solved.moves, &waiting, &left) {
            Ok(ways) => Some(ways),
            Err(Limit::Memory) => None,
            Err(Limit::Time) => return Err(VoyageError::OutOfTime("the search of abort tracks")),
        };
        let room_m = waiting.room_m;
        let from = |end: Pose| match &ways {
            Some(ways) => {
                let none = || format!("no moves lead to water with {room_m:.0} m of room (`abort_room_m`)");
                ways.steps(end).ok_or_else(none)
            }
            None => Err("its search exceeds --memory-mib".to_owned()),
        };
        let moves = solved.solution.steps.iter().map(|step| from(step.to)).collect();
        drop(ways);
        Ok(WaysOfPlan { waiting, moves })
    }

    /// Their legs, by step; none where there is no way, or nothing to sail.
    pub(super) fn legs_of_ways<'a>(&'a self, solved: &Solved, ways: &WaysOfPlan) -> Vec<Legs<'a>> {
        let leg = |step: &Step| (self.node(step.from), &self.legs[solved.moves.leg_of_step(step)].leg);
        ways.moves.iter().map(|moves| moves.iter().flatten().map(leg).collect()).collect()
    }

    /// What becomes of the ship if it fails, by step: `sailed` is the nominal track, and `aborted` what became of all vessels on
    /// the abort tracks, with the poses of the nominal one.
    pub(super) fn failures(
        &self,
        (solved, sailed): (&Solved, &Sailed),
        ways: WaysOfPlan,
        aborted: Vec<(Aborted, Vec<AtSea>)>,
        clearance: &Clearance,
        search: &Search,
    ) -> Result<Vec<LegFailure>, VoyageError> {
        let steps = &solved.solution.steps;
        let drift = |step| self.drift(sailed, step, clearance, search);
        let drifts: Vec<_> = (0..steps.len()).into_par_iter().map(drift).collect();
        let WaysOfPlan { waiting, moves } = ways;
        let tracks = steps.iter().zip(moves).zip(aborted).map(|((step, moves), (aborted, poses))| {
            let track = self.track(solved, step, (&moves?, &waiting), (aborted, poses.len()))?;
            Ok((track, poses.iter().map(|pose| [pose.y, pose.x]).collect()))
        });
        tracks.zip(drifts).map(|(abort, drift)| Ok(LegFailure { abort, drift: drift? })).collect()
    }

    /// The abort track of these moves from the end of a step, if all vessels keep their margin on it. The nominal one has so
    /// many poses there.
    fn track(
        &self,
        solved: &Solved,
        step: &Step,
        (moves, waiting): (&[Step], &Waiting),
        (aborted, poses): (Aborted, usize),
    ) -> Result<AbortTrack, String> {
        let Self { brief, chart, grid, .. } = self;
        let Aborted { vessels, clearance_m, aground, below_margin } = aborted;
        if below_margin > 0 {
            let what = format!(
                "{below_margin} of {vessels} vessels come nearer than the margin, {aground} of them aground"
            );
            return Err(format!("on the way to the nearest place to wait {what}"));
        }
        let to = moves.last().unwrap_or(step).to;
        let [from, place] = [step.to, to].map(|pose| self.node(pose));
        let east_north = [place[1], place[0]];
        let (longitude_deg, latitude_deg) = chart.plane().to_geographic(east_north);
        let way = self.route([from, place]);
        let of_move = |step: &Step| {
            let (level, mode) = grid.level_and_mode(step.to.layer);
            AbortMove {
                action: solved.moves.actions[step.action].name.clone(),
                i: step.to.i as u64,
                j: step.to.j as u64,
                h: level as u64,
                mode: grid.modes[mode].name.clone(),
            }
        };
        Ok(AbortTrack {
            kind: waiting.place(to).unwrap_or(WaitingPlace::OpenWater),
            longitude_deg,
            latitude_deg,
            depth_m: chart.least_depth_m(&[east_north]),
            room_m: waiting.room_m,
            towards_deg: way.course_deg(0).filter(|_| from != place),
            distance_m: way.leg_m(0).unwrap_or(0.0),
            duration_s: poses.saturating_sub(1) as f64 / brief.vessel.sample_rate_hz,
            moves: moves.iter().map(of_move).collect(),
            vessels: if moves.is_empty() { 0 } else { vessels },
            aground,
            clearance_m: Some(clearance_m).filter(|_| !moves.is_empty()),
        })
    }

    /// How she drifts from anywhere on a step.
    fn drift(
        &self,
        sailed: &Sailed,
        step: usize,
        clearance: &Clearance,
        search: &Search,
    ) -> Result<LegDrift, VoyageError> {
        if !(search.keep_going)() {
            return Err(VoyageError::OutOfTime("the drift of ships with their engine stopped"));
        }
        let rate_hz = self.brief.vessel.sample_rate_hz;
        let first = sailed.samples.partition_point(|sample| sample.leg < step);
        let samples = sailed.samples.partition_point(|sample| sample.leg <= step) - first;
        let stops = samples.min(STOPS);
        let mut worst = Drifted { clearance_m: clearance.sight_m, nearest_s: 0.0, stopped_s: 0.0 };
        let (mut drifted, mut aground) = (0, 0);
        for stop in 1..=stops {
            let index = first + stop * samples / stops - 1;
            for who in std::iter::once(None).chain(self.others.iter().enumerate().map(Some)) {
                // What is less near than the worst so far does not matter.
                let least_m = worst.clearance_m.max(f64::MIN_POSITIVE);
                let one = self.drifted(&sailed.samples[index], who, (clearance, least_m));
                drifted += 1;
                aground += u64::from(one.clearance_m <= 0.0);
                worst = worst.worse(Drifted { stopped_s: (index + 1) as f64 / rate_hz, ..one });
            }
        }
        let Drifted { clearance_m, nearest_s, stopped_s } = worst;
        let lasts_s = self.brief.task.failing.drift_s;
        Ok(LegDrift { lasts_s, drifted, aground, clearance_m, nearest_s, stopped_s })
    }

    /// A vessel whose engine stops at the end of `sample`: the nominal one, or a sampled one with its number. Distances from
    /// `least_m` on do not matter.
    fn drifted(
        &self,
        sample: &Sample,
        who: Option<(usize, &SampledVessel)>,
        (clearance, least_m): (&Clearance, f64),
    ) -> Drifted {
        let Brief { vessel, task, seed, .. } = &self.brief;
        let parameters = who.map_or(&vessel.nominal, |(_, who)| &who.parameters);
        let unknown = who.map_or([0.0; 2], |(run, _)| {
            let (sin, cos) = libm::sincos(TAU * run as f64 / self.others.len() as f64);
            [cos, sin].map(|part| task.safety.unknown_current_m_s * part)
        });
        let mut ship = Ship::new(vessel, parameters, sample.pose, 0.0);
        ship.state = sample.state;
        ship.current_m_s = [0, 1].map(|d| task.known_current_m_s[d] + unknown[d]);
        ship.changing = who.and_then(|(run, _)| {
            task.changes.of_run(Streams::new(*seed, "drift"), run as u32, vessel.sample_rate_hz)
        });
        // Her actuators are where they were.
        ship.command(&sample.inputs, None);
        let (idle, mut passage) = (idle(vessel), clearance.open());
        passage.clearance_m = least_m;
        let mut nearest = Drifted { clearance_m: passage.clearance_m, nearest_s: 0.0, stopped_s: 0.0 };
        for sample in 0..=vessel.samples(task.failing.drift_s) {
            clearance.add(&mut passage, ship.pose, false);
            if passage.clearance_m < nearest.clearance_m {
                let nearest_s = sample as f64 / vessel.sample_rate_hz;
                nearest = Drifted { clearance_m: passage.clearance_m, nearest_s, ..nearest };
            }
            ship.command(&idle, None);
            if nearest.clearance_m <= 0.0 || !ship.state.iter().all(|speed| speed.abs() <= DIVERGED) {
                break;
            }
        }
        nearest
    }
}

impl LegFailure {
    /// The legs without an abort track, in words; `None` where each has one.
    pub(super) fn without_abort(all: &[Self], name: impl Fn(usize) -> String) -> Option<String> {
        let steps = all.iter().enumerate();
        let without = steps.filter_map(|(step, one)| Some((step, one.abort.as_ref().err()?)));
        let said: Vec<String> =
            without.map(|(step, why)| format!("{} `{}` ({why})", step + 1, name(step))).collect();
        (!said.is_empty()).then(|| said.join(", "))
    }
}
