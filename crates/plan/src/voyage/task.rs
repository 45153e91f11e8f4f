//! The task of a trial on a chart.

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use chart::Layer;
use chart::route::KNOT_M_S;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use ship::engine::{Changes, Helm, MOST_CURRENT_M_S, Measurement, Run, Streams};
use ship::model::Vessel;

use super::passage::{Tide, Times};
use crate::sampled_vessel::Doubt;
use crate::{Approach, DerivedHandling, Deviations, Handling, Mode, SampledVessel, Sensors};

/// The inputs of planning a voyage.
#[derive(Clone, Debug)]
pub struct Brief {
    /// The vessel.
    pub vessel: Vessel,
    /// The task.
    pub task: Task,
    /// The charts.
    pub layers: Vec<Layer>,
    /// Bytes of memory for reading them, of which the allocator keeps most for a while.
    pub chart_bytes: u64,
    /// The dictionary's maneuvers, one per run.
    pub dictionary: Vec<Run>,
    /// The commands of those that react to the ship, by name.
    pub programs: BTreeMap<String, Helm>,
    /// The design's shares, for counts that follow from them.
    pub design: Option<Shares>,
    /// Seed of the sampled vessels' parameters and of the currents of checks.
    pub seed: u64,
}

/// A design's shares of the time in maneuvers.
#[derive(Clone, Debug)]
pub struct Shares {
    /// The design's maneuvers, in its order.
    pub order: Vec<String>,
    /// N_q/N by maneuver.
    pub share: BTreeMap<String, f64>,
}

/// The task of a trial on a chart.
#[derive(Clone, Debug)]
pub struct Task {
    /// Where the ship may sail.
    pub area: Area,
    /// Distance of neighbouring nodes of the lattice \[m\].
    pub cell_m: f64,
    /// Heading levels: 4, 8 or 16.
    pub headings: usize,
    /// Raster cells per lattice cell, even.
    pub raster_per_cell: usize,
    /// How uncharted places are treated: by default as obstacles if a chart has depths, else as water.
    pub uncharted: Option<chart::Uncharted>,
    /// The hull.
    pub hull: Hull,
    /// Depths and distances to keep.
    pub safety: Safety,
    /// The vessels that the plan has to hold for.
    pub deviations: Deviations,
    /// The noise of the ship's sensors.
    pub sensors: Sensors,
    /// The noise of the logs, of a ship with forces.
    pub measurement: Option<Measurement>,
    /// What states the errors of [`Safety::standard_errors`].
    pub errors_from: Option<ErrorsFrom>,
    /// How current and wind change while the ship sails.
    pub changes: Changes,
    /// North and east components of the known current \[m/s\].
    pub known_current_m_s: [f64; 2],
    /// How the vessel is handled between maneuvers.
    pub handling: Handling,
    /// How it would be handled by default.
    pub derived: DerivedHandling,
    /// The parts before and after a maneuver.
    pub approach: Approach,
    /// Speeds that the vessel may have at a node, besides being at rest.
    pub modes: Vec<Mode>,
    /// Speed limits in parts of the area.
    pub speed_limits: Vec<SpeedLimit>,
    /// The maneuvers to place; by default those of the design.
    pub maneuvers: Vec<ManeuverUse>,
    /// Time in informative maneuvers, for counts that follow from the design's shares \[s\].
    pub informative_s: Option<f64>,
    /// The departure \[s since 1970, UTC\], if known.
    pub departure: Option<i64>,
    /// Where the trial begins.
    pub start: Place,
    /// Where it may end.
    pub goal: Goal,
    /// The cost to minimize.
    pub cost: CostRule,
    /// The tide, which is included in depths and currents already.
    pub tide: Option<Tide>,
    /// When it has to be over; `None` if only the tide limits it.
    pub slot: Option<Slot>,
    /// When such trials may be.
    pub times: Times,
    /// Whether the lattice is moved so that its start is a node.
    pub on_node: bool,
    /// What becomes of her if it fails.
    pub failing: Failing,
    /// How far from a right angle she may cross a traffic lane \[rad\].
    pub crossing_rad: f64,
}

/// What a plan tells of a ship if it fails.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Failing {
    /// Whether every leg needs an abort track.
    pub abort: AbortRule,
    /// For how long she drifts with her engine stopped \[s\].
    pub drift_s: f64,
    /// How much room she needs around her where she waits, besides hull and margin; by default that of her slowest circle, and
    /// at least her length \[m\].
    pub room_m: Option<f64>,
}

refusal::choices! {
    /// Whether legs need an abort track.
    pub enum AbortRule {
        /// Legs without one are named.
        Told = "told",
        /// Legs without one are not sailed.
        Required = "required",
    }
}

impl Task {
    /// The task in a tide.
    pub fn with_tide(mut self, tide: Tide) -> Self {
        self.safety.transit_depth_m -= tide.level_m;
        self.safety.trial_depth_m -= tide.level_m;
        self.safety.unknown_current_m_s += tide.spread_m_s;
        for (current, stream) in self.known_current_m_s.iter_mut().zip(tide.stream_m_s) {
            *current += stream;
        }
        self.tide = Some(tide);
        self
    }

    /// The task for a ship that begins at `departure` instead \[s since 1970, UTC\]: what limits its time ends when it did.
    #[must_use]
    pub fn departing(mut self, departure: i64) -> Self {
        let later_s = self.departure.map_or(0.0, |planned| (departure - planned) as f64);
        self.departure = Some(departure);
        self.slot = self.slot.map(|slot| Slot { lasts_s: slot.lasts_s - later_s, ..slot });
        self.tide = self.tide.map(|tide| Tide { slot_s: tide.slot_s - later_s, ..tide });
        self
    }
}

/// The navigable area, in degrees: a box, or a polygon within it. The lattice covers the box.
#[derive(Clone, Debug)]
pub struct Area {
    /// Western edge; east of the eastern one where the area lies across the antimeridian.
    pub west_deg: f64,
    /// Southern edge.
    pub south_deg: f64,
    /// Eastern edge.
    pub east_deg: f64,
    /// Northern edge.
    pub north_deg: f64,
    /// Longitude and latitude of the polygon's corners, in order; empty if the area is the whole box.
    pub corners: Vec<[f64; 2]>,
}

/// The time limit of a trial.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Slot {
    /// The key that states it.
    pub key: &'static str,
    /// After the departure \[s\].
    pub lasts_s: f64,
}

/// A speed limit in a part of the area: faster legs are not offered where they sweep any of it.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SpeedLimit {
    /// Its name in messages.
    pub name: Option<String>,
    /// Longitude and latitude of its polygon's corners, in either sense \[deg\].
    pub corners: Vec<[f64; 2]>,
    /// The limit, over the ground \[m/s\].
    #[schemars(range(max = 1e3), extend("exclusiveMinimum" = 0.0))]
    pub max_speed_m_s: f64,
}

/// The hull in the horizontal plane: a rectangle with a pointed bow.
#[derive(Clone, Copy, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Hull {
    /// Length over all \[m\].
    #[schemars(range(max = 1e3), extend("exclusiveMinimum" = 0.0))]
    pub length_m: f64,
    /// Beam \[m\].
    #[schemars(range(max = 1e3), extend("exclusiveMinimum" = 0.0))]
    pub beam_m: f64,
    /// Distance of the reference point forward of midships \[m\].
    #[serde(default)]
    pub reference_m: f64,
    /// Air draught, including the required clearance \[m\]; without it no bridge of a chart is high enough.
    #[schemars(range(max = 200.0), extend("exclusiveMinimum" = 0.0))]
    pub air_draught_m: Option<f64>,
    /// Draught \[m\], from which the passage plan computes the under-keel clearance.
    #[schemars(range(max = 200.0), extend("exclusiveMinimum" = 0.0))]
    pub draught_m: Option<f64>,
    /// Block coefficient, by which she squats under way; without it no squat is counted.
    #[schemars(range(min = 0.2, max = 1.0), extend("x-unit" = "1"))]
    pub block_coefficient: Option<f64>,
}

/// Squat in open water \[m\] of a ship under way: C_B V²/100 with V in knots (C. B. Barrass, *Ship Squat and Interaction*, 2009).
pub(super) fn squat_m(block_coefficient: f64, speed_m_s: f64) -> f64 {
    block_coefficient * (speed_m_s / KNOT_M_S).powi(2) / 100.0
}

impl Hull {
    /// Corners about the reference point, x forward, y to starboard \[m\].
    pub fn outline(&self) -> Vec<[f64; 2]> {
        let (bow, side) = (self.length_m / 2.0 - self.reference_m, self.beam_m / 2.0);
        let stern = bow - self.length_m;
        let shoulder = bow - self.length_m * 0.2;
        vec![[bow, 0.0], [shoulder, side], [stern, side], [stern, -side], [shoulder, -side]]
    }

    /// Points of its rectangle about the reference point, x forward, y to starboard, at most `apart_m` apart \[m\].
    pub fn body(&self, apart_m: f64) -> Vec<[f64; 2]> {
        let steps = |length: f64| (length / apart_m).ceil().max(1.0) as u32;
        let (long, wide) = (steps(self.length_m), steps(self.beam_m));
        let stern = -self.length_m / 2.0 - self.reference_m;
        let x = move |k: u32| stern + self.length_m * f64::from(k) / f64::from(long);
        let y = move |k: u32| self.beam_m * (f64::from(k) / f64::from(wide) - 0.5);
        (0..=long).flat_map(|i| (0..=wide).map(move |j| [x(i), y(j)])).collect()
    }
}

/// Depths and distances to keep.
#[derive(Clone, Copy, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Safety {
    /// Least charted depth in transit: draught and under-keel clearance \[m\].
    #[serde(default)]
    #[schemars(range(min = 0.0, max = 12000.0))]
    pub transit_depth_m: f64,
    /// Least charted depth for informative maneuvers \[m\].
    #[serde(default)]
    #[schemars(range(min = 0.0, max = 12000.0))]
    pub trial_depth_m: f64,
    /// Distance that the hull keeps from obstacles \[m\].
    #[schemars(range(min = 0.0, max = 1e5))]
    pub margin_m: f64,
    /// Least water under the keel on every leg \[m\]: charted depth and tide, less draught and squat.
    #[schemars(range(min = 0.0, max = 100.0))]
    pub under_keel_m: Option<f64>,
    /// Bound on the unknown current \[m/s\].
    #[serde(default)]
    #[schemars(range(min = 0.0, max = MOST_CURRENT_M_S))]
    pub unknown_current_m_s: f64,
    /// Relative error of the nominal parameters: maneuvers have room for vessels with such errors.
    #[serde(default)]
    #[schemars(range(min = 0.0, max = 0.99), extend("x-unit" = "(1 is 100 %)"))]
    pub parameter_error: f64,
    /// Instead of that: so many standard errors of the covariance of a `model.json`, jointly; for the `vessel.toml` of a
    /// ship with forces so many standard deviations of the priors of her numbers, jointly.
    #[schemars(range(max = 10.0), extend("exclusiveMinimum" = 0.0, "x-unit" = "standard errors"))]
    pub standard_errors: Option<f64>,
    /// Simulations of the finished plan with such currents and vessels; by default as many as `aground_probability` needs.
    #[schemars(range(min = 1, max = 1000000), extend("x-unit" = "runs"))]
    pub runs: Option<u32>,
    /// Without effect, for files that have it: every run has a vessel of its own.
    pub vessels: Option<u32>,
    /// The probability of running aground that the check must exclude, with 95 % confidence.
    #[schemars(range(min = 1e-5, max = 0.5))]
    pub aground_probability: Option<f64>,
}

impl Safety {
    /// The key that bounds the parameters.
    pub(super) fn key(&self) -> &'static str {
        key_of(self.standard_errors)
    }
}

/// The key that bounds the parameters, by the value of `safety.standard_errors`.
pub(super) fn key_of(standard_errors: Option<f64>) -> &'static str {
    if standard_errors.is_some() { "safety.standard_errors" } else { "safety.parameter_error" }
}

refusal::choices! {
    /// What states the errors of a vessel's parameters.
    pub enum ErrorsFrom {
        /// The covariance of a `model.json`.
        Covariance = "covariance",
        /// The priors of the free numbers of a ship with forces, each independent of the others.
        Priors = "priors",
    }
}

/// A maneuver to place.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ManeuverUse {
    /// Its name in the dictionary.
    pub name: String,
    /// Number of uses; by default from the design's share.
    pub count: Option<u32>,
    /// Length of one piece, cut to whole periods if the maneuver is periodic; by default the whole maneuver \[s\].
    #[schemars(range(max = 1e7), extend("exclusiveMinimum" = 0.0))]
    pub piece_s: Option<f64>,
}

/// A place and heading.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Place {
    /// Longitude.
    pub longitude_deg: f64,
    /// Latitude.
    pub latitude_deg: f64,
    /// Compass heading.
    pub heading_deg: f64,
    /// Speed mode; by default at rest (or the slowest if there is no rest).
    pub mode: Option<String>,
}

/// Where the trial may end.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum Goal {
    /// Back at the start.
    Home {},
    /// Anywhere.
    Any {},
    /// At one of these places.
    Places {
        /// The places.
        places: Vec<Place>,
    },
}

/// The objective.
#[derive(Clone, Copy, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct CostRule {
    /// The primary objective.
    pub primary: Primary,
    /// Decides between plans of equal primary cost.
    pub secondary: Secondary,
}

/// The primary objective.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Primary {
    /// The number of basic moves, as in the paper.
    #[default]
    BasicMoves,
    /// The time of the trial.
    Seconds,
}

/// What is minimised among plans that are equal in that.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Secondary {
    /// The time of the trial.
    #[default]
    Seconds,
    /// The number of turns.
    Turns,
    /// Nearness to obstacles at the nodes.
    Clearance,
}

/// Number of sampled vessels on every leg, besides the nominal vessel on its node.
const SAMPLED: u32 = 32;
/// Resolution of the draws.
const STEPS: u32 = 1 << 20;

impl Brief {
    /// The vessels and currents that legs and plans have to hold for.
    pub(crate) fn doubt(&self) -> Doubt<'_> {
        let (nominal, current_m_s) = (&self.vessel.nominal, self.task.safety.unknown_current_m_s);
        Doubt { nominal, deviations: &self.task.deviations, current_m_s }
    }

    /// The sampled vessels of every leg: parameters uniform within the stated error, currents of any direction, offsets from
    /// anywhere that legs may end. Half of them begin at the edge of the tolerance, in the strongest current.
    pub(super) fn sampled_vessels(&self) -> Vec<SampledVessel> {
        (0..SAMPLED).map(|run| self.sampled_vessel(run)).collect()
    }

    fn sampled_vessel(&self, run: u32) -> SampledVessel {
        let drawn = Streams::new(self.seed, "rehearsal").choices(run, 0, STEPS, 9);
        let part = |i: usize| (f64::from(drawn[i]) + 0.5) / f64::from(STEPS);
        let extreme = run.is_multiple_of(2);
        let size = |i: usize| if extreme { 1.0 } else { part(i) };
        // From -1 to 1.
        let offset = |i: usize| if extreme { (2.0 * part(i) - 1.0).signum() } else { 2.0 * part(i) - 1.0 };
        let (towards, away) = (libm::sincos(TAU * part(0)), libm::sincos(TAU * part(1)));
        let tolerance = self.task.approach.tolerance.begun();
        let current = self.task.safety.unknown_current_m_s * size(2);
        let distance = tolerance.distance_m * size(3).sqrt();
        let most = [tolerance.surge_m_s, tolerance.sway_m_s, tolerance.yaw_rate_rad_s];
        SampledVessel {
            parameters: self.drawn("parameter-error", run),
            current_m_s: [current * towards.1, current * towards.0],
            off: [distance * away.1, distance * away.0, tolerance.heading_rad * offset(4)],
            motion: [0, 1, 2].map(|d: usize| most[d] * offset(5 + d)),
        }
    }

    /// Parameters of run `run`: uniform within the stated errors of the nominal ones.
    pub(super) fn drawn(&self, purpose: &str, run: u32) -> Vec<f64> {
        let (streams, count) = (Streams::new(self.seed, purpose), self.vessel.nominal.len());
        let drawn = streams.choices(run, 0, STEPS, count);
        let uniform: Vec<f64> =
            drawn.iter().map(|draw| 2.0 * (f64::from(*draw) + 0.5) / f64::from(STEPS) - 1.0).collect();
        let mut normal = vec![0.0; count];
        streams.normals(run, 1, &mut normal);
        let deviations = &self.task.deviations;
        deviations.parameters(&self.vessel.nominal, &deviations.drawn(&uniform, &normal))
    }

    /// A constant current of run `run`, north and east: any direction, any strength up to the bound.
    pub(super) fn current(&self, purpose: &str, run: u32) -> [f64; 2] {
        let drawn = Streams::new(self.seed, purpose).choices(run, 0, STEPS, 2);
        let part = |i: usize| (f64::from(drawn[i]) + 0.5) / f64::from(STEPS);
        let (sin, cos) = libm::sincos(TAU * part(0));
        let speed = self.task.safety.unknown_current_m_s * part(1);
        [speed * cos, speed * sin]
    }
}
