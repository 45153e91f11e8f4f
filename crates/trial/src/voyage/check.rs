//! The finished plan in continuous space: how near the hull comes to what is charted as an obstacle, by the nominal model,
//! and by vessels and in currents that are not known.

use chart::{Bounds, Invalid, Obstacles, Raster};
use numerics::statistics::{quantile, sorted, wilson};
use rayon::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use vessel::{Pose, Streams};

use super::error::VoyageError;
use super::prepared::Prepared;
use super::script::Script;
use super::search::Search;
use super::task::Brief;
use crate::{Sailed, Sample};

/// How far beyond the lattice a hull's clearance is still measured \[m\]. The chart is read farther than that.
const BEYOND_M: f64 = 500.0;
/// Raster cells that distances are measured on, at most, unless the lattice's own raster has more.
const MOST_CELLS: f64 = 4e6;
/// Cells of that raster per cell of the lattice's raster, at most.
const FINEST: u32 = 8;
/// Tracks that are kept to be drawn.
const TRACKS: u32 = 200;

/// The plan simulated in continuous space.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Check {
    /// Whether the hull keeps its margin in every simulation.
    pub safe: bool,
    /// What is broken, in words; empty for a safe plan.
    pub faults: Vec<String>,
    /// Least distance of the hull from anything charted as an obstacle, nominal model, known current \[m\].
    pub clearance_m: f64,
    /// Whether the hull stays clear.
    pub clear: bool,
    /// Distance that was asked for \[m\]; maneuvers keep the drift of the unknown current besides.
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
    /// Simulations of the whole plan, each with a constant current and parameters of its own, even within those bounds.
    pub runs: u64,
    /// Of which touched an obstacle, or went where the chart was not read.
    pub aground: u64,
    /// The share of them that this leaves possible, Wilson's 95 %.
    pub aground_interval: [f64; 2],
    /// Runs that came nearer than the margin, those aground among them.
    pub below_margin: u64,
    /// Runs that left the lattice's area, which is no obstacle.
    pub left_area: u64,
    /// Least clearance of each run: smallest, 5 %, median \[m\].
    pub clearance_quantiles_m: [f64; 3],
    /// The same runs without corrections between maneuvers (the autopilot reckons with the nominal track only).
    pub aground_open_loop: u64,
}

/// Distance of the hull from obstacles.
pub(super) struct Clearance<'a> {
    prepared: &'a Prepared,
    /// Outline about the reference point, x forward, y to starboard \[m\], with the middles of its sides.
    outline: Vec<[f64; 2]>,
    /// In transit.
    transit: Obstacles,
    /// In informative maneuvers.
    trial: Obstacles,
    /// The lattice's area.
    area: Bounds,
    /// As far as distances are measured \[m\].
    sight_m: f64,
}

/// What a track came to.
#[derive(Clone, Copy, Debug)]
struct Passage {
    /// Least distance from obstacles; 0 where the chart was not read \[m\].
    clearance_m: f64,
    /// Whether the hull left the lattice's area.
    left_area: bool,
}

impl<'a> Clearance<'a> {
    /// Rasters of the chart around the lattice, finer than those of the search.
    pub(super) fn new(prepared: &'a Prepared) -> Result<Self, Invalid> {
        let task = &prepared.brief.task;
        let (own, sight_m) = (task.raster(&prepared.grid), prepared.sight_m());
        let area = own.bounds();
        let raster = fine(&area.grown(BEYOND_M), own.cell_m, sight_m)?;
        let corners = task.hull.outline();
        let between = |(a, b): (&[f64; 2], &[f64; 2])| [*a, [(a[0] + b[0]) / 2.0, (a[1] + b[1]) / 2.0]];
        let outline = corners.iter().zip(corners.iter().cycle().skip(1)).flat_map(between).collect();
        let transit = Obstacles::in_transit(&prepared.chart, raster, task.safety.transit_depth_m, sight_m)?;
        let trial = Obstacles::new(&prepared.chart, raster, task.safety.trial_depth_m, sight_m)?;
        Ok(Self { prepared, outline, transit, trial, area, sight_m })
    }

    /// Of the hull at a sample.
    fn at(&self, pose: Pose, informative: bool) -> Passage {
        let (sin, cos) = libm::sincos(pose.psi);
        let obstacles = if informative { &self.trial } else { &self.transit };
        let mut own = Passage { clearance_m: self.sight_m, left_area: false };
        for [x, y] in &self.outline {
            let place = [pose.y + x * sin + y * cos, pose.x + x * cos - y * sin];
            own.clearance_m = own.clearance_m.min(obstacles.distance_m(place[0], place[1]));
            own.left_area |= !self.area.contains(place);
        }
        own
    }

    /// Along a track.
    fn of(&self, sailed: &Sailed) -> Passage {
        let start = Passage { clearance_m: self.sight_m, left_area: false };
        sailed.samples.iter().map(|s| self.at(s.pose, s.informative)).fold(start, |a, b| Passage {
            clearance_m: a.clearance_m.min(b.clearance_m),
            left_area: a.left_area || b.left_area,
        })
    }

    /// By how much a track falls short of the margin, and in the maneuvers of `legs` of the drift besides.
    fn shortfall_m(&self, sailed: &Sailed, legs: &[usize]) -> f64 {
        let margin_m = self.prepared.brief.task.safety.margin_m;
        let drift_m = |s: &Sample| match s.informative {
            true => self.prepared.drift_margin_m(&self.prepared.rehearsed[legs[s.leg]]),
            false => 0.0,
        };
        let short = |s: &Sample| margin_m + drift_m(s) - self.at(s.pose, s.informative).clearance_m;
        sailed.samples.iter().map(short).fold(0.0, f64::max)
    }

    /// Sails the script with parameters and in currents that are not known: the check, and tracks to be drawn. `nominal`
    /// is the script sailed by the nominal model without unknown current, `legs` are those of its steps.
    ///
    /// # Errors
    /// A command that the model cannot hold, a simulation that diverges; no time.
    pub(super) fn check(
        &self,
        script: &Script<'_>,
        nominal: &Sailed,
        legs: &[usize],
        search: &Search,
    ) -> Result<(Check, Vec<Sailed>), VoyageError> {
        let brief = &script.prepared.brief;
        let (safety, go_on) = (brief.task.safety, search.go_on);
        let one = |run: u32| {
            if !go_on() {
                return Err(VoyageError::OutOfTime("the check of the plan"));
            }
            let (parameters, unknown) = (brief.drawn("checked-parameters", run), brief.current(run));
            // A drawn vessel that cannot be sailed is no fault of a file.
            let sailed = script.sail(&parameters, unknown).map_err(VoyageError::NoAnswer)?;
            let open = script.repeat(nominal, &parameters, unknown);
            Ok((self.of(&sailed), self.of(&open), (run < TRACKS).then_some(sailed)))
        };
        let found: Vec<(Passage, Passage, Option<Sailed>)> =
            (0..safety.runs).into_par_iter().map(one).collect::<Result<_, VoyageError>>()?;
        let least = sorted(found.iter().map(|(passage, ..)| Some(passage.clearance_m)));
        let count = |is: &dyn Fn(&Passage, &Passage) -> bool| {
            found.iter().filter(|(sailed, open, _)| is(sailed, open)).count() as u64
        };
        let (own, runs) = (self.of(nominal), u64::from(safety.runs));
        let aground = count(&|sailed, _| sailed.clearance_m <= 0.0);
        let check = Check {
            safe: false,
            faults: Vec::new(),
            clearance_m: own.clearance_m,
            clear: own.clearance_m > 0.0,
            margin_m: safety.margin_m,
            shortfall_m: self.shortfall_m(nominal, legs),
            sight_m: self.sight_m,
            unknown_current_m_s: safety.unknown_current_m_s,
            parameter_error: safety.parameter_error,
            seed: brief.seed,
            runs,
            aground,
            aground_interval: wilson(aground, runs).unwrap_or([0.0, 1.0]),
            below_margin: count(&|sailed, _| sailed.clearance_m < safety.margin_m),
            left_area: count(&|sailed, _| sailed.left_area),
            clearance_quantiles_m: [0.0, 0.05, 0.5].map(|q| quantile(&least, q).unwrap_or(0.0)),
            aground_open_loop: count(&|_, open| open.clearance_m <= 0.0),
        };
        Ok((check.judged(), found.into_iter().filter_map(|(.., sailed)| sailed).collect()))
    }
}

impl Check {
    /// With its faults in words.
    fn judged(mut self) -> Self {
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
        (self.safe, self.faults) = (faults.is_empty(), faults);
        self
    }
}

/// The finest raster over `bounds`, of whole parts of `cell_m`, that still has a sensible number of cells `around_m` included.
fn fine(bounds: &Bounds, cell_m: f64, around_m: f64) -> Result<Raster, Invalid> {
    let wide = bounds.grown(around_m);
    let cells =
        |parts: u32| (0..2).map(|k| (wide.max[k] - wide.min[k]) / cell_m * f64::from(parts)).product::<f64>();
    let parts = (2..=FINEST).rev().find(|parts| cells(*parts) <= MOST_CELLS).unwrap_or(1);
    Raster::covering(bounds, cell_m / f64::from(parts))
}

impl Prepared {
    /// As far as distances from obstacles are measured in the check \[m\]: the chart is read as far all around.
    fn sight_m(&self) -> f64 {
        let drift_m = self.rehearsed.iter().map(|own| self.drift_margin_m(own)).fold(0.0, f64::max);
        BEYOND_M + self.brief.task.safety.margin_m + drift_m
    }
}

impl Brief {
    /// A constant current of run `run`, north and east: any direction, any strength up to the bound.
    fn current(&self, run: u32) -> [f64; 2] {
        const STEPS: u32 = 1 << 20;
        let drawn = Streams::new(self.seed, "unknown-current").choices(run, 0, STEPS, 2);
        let part = |i: usize| (f64::from(drawn[i]) + 0.5) / f64::from(STEPS);
        let (sin, cos) = libm::sincos(std::f64::consts::TAU * part(0));
        let speed = self.task.safety.unknown_current_m_s * part(1);
        [speed * cos, speed * sin]
    }
}
