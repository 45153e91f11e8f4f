//! What a trial on a chart is asked to do.

use std::collections::BTreeMap;

use chart::Layer;
use engine::Run;
use model::Vessel;
use serde::{Deserialize, Serialize};

use super::tide::Tide;
use crate::{Approach, DerivedHandling, Handling, Mode};

/// What a voyage is planned from.
#[derive(Clone, Debug)]
pub struct Brief {
    /// The vessel.
    pub vessel: Vessel,
    /// What is asked.
    pub task: Task,
    /// The charts.
    pub layers: Vec<Layer>,
    /// Bytes of memory that reading them took, of which the allocator keeps most for a while.
    pub chart_bytes: u64,
    /// The dictionary's maneuvers, one per run.
    pub dictionary: Vec<Run>,
    /// The design's shares, for counts that follow from them.
    pub design: Option<Shares>,
    /// Seed of the rehearsing vessels' parameters and of the currents that a plan is checked in.
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

/// What a trial on a chart is asked to do, and where.
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
    /// What uncharted places count as: obstacles as soon as a chart has depths, else water.
    pub uncharted: Option<chart::Uncharted>,
    /// The hull.
    pub hull: Hull,
    /// Depths and distances to keep.
    pub safety: Safety,
    /// North and east components of the current that is known \[m/s\].
    pub known_current_m_s: [f64; 2],
    /// How the vessel is handled between maneuvers.
    pub handling: Handling,
    /// How it would be, if nobody said anything.
    pub derived: DerivedHandling,
    /// What comes before and after a maneuver.
    pub approach: Approach,
    /// Speeds that the vessel may have at a node, besides being at rest.
    pub modes: Vec<Mode>,
    /// Speeds that are not exceeded in parts of the area.
    pub speed_limits: Vec<SpeedLimit>,
    /// The maneuvers to place; without any, those of the design.
    pub maneuvers: Vec<ManeuverUse>,
    /// Time in informative maneuvers, for counts that follow from the design's shares \[s\].
    pub informative_s: Option<f64>,
    /// When the trial begins \[s since 1970, UTC\], where it is known.
    pub departure: Option<i64>,
    /// Where the trial begins.
    pub start: Place,
    /// Where it may end.
    pub goal: Goal,
    /// What is minimised.
    pub cost: CostRule,
    /// The tide, which depths and currents count with already.
    pub tide: Option<Tide>,
    /// When it has to be over; None where only the tide says.
    pub slot: Option<Slot>,
    /// Whether the lattice is moved so that its start is a node.
    pub on_node: bool,
}

impl Task {
    /// The same task in a tide.
    pub fn with_tide(mut self, tide: Tide) -> Self {
        self.safety.transit_depth_m -= tide.level_m;
        self.safety.trial_depth_m -= tide.level_m;
        self.safety.unknown_current_m_s += tide.spread_m_s;
        for (own, stream) in self.known_current_m_s.iter_mut().zip(tide.stream_m_s) {
            *own += stream;
        }
        self.tide = Some(tide);
        self
    }
}

/// Where the ship may sail, in degrees: a box, or a polygon within it. The lattice covers the box.
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
    /// Longitude and latitude of the polygon's corners, in their order; none where all of the box is meant.
    pub corners: Vec<[f64; 2]>,
}

/// When a trial has to be over.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Slot {
    /// The key that says so.
    pub key: &'static str,
    /// After the departure \[s\].
    pub lasts_s: f64,
}

/// A speed that is not exceeded in a part of the area: legs that do are not offered where any of it is swept.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SpeedLimit {
    /// What messages call it.
    pub name: Option<String>,
    /// Longitude and latitude of its polygon's corners, in their order, either way round \[deg\].
    pub corners: Vec<[f64; 2]>,
    /// The limit, over the ground \[m/s\].
    pub max_speed_m_s: f64,
}

/// The hull in the horizontal plane: a rectangle with a pointed bow.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Hull {
    /// Length over all \[m\].
    pub length_m: f64,
    /// Beam \[m\].
    pub beam_m: f64,
    /// Distance of the reference point forward of the middle \[m\].
    #[serde(default)]
    pub reference_m: f64,
    /// Height above water, with what is to stay free over it \[m\]; without it no bridge of a chart is high enough.
    pub air_draught_m: Option<f64>,
    /// Draught \[m\]: the passage plan tells the water under the keel with it.
    pub draught_m: Option<f64>,
}

impl Hull {
    /// Corners about the reference point, x forward, y to starboard \[m\].
    pub fn outline(&self) -> Vec<[f64; 2]> {
        let (bow, side) = (self.length_m / 2.0 - self.reference_m, self.beam_m / 2.0);
        let stern = bow - self.length_m;
        let shoulder = bow - self.length_m * 0.2;
        vec![[bow, 0.0], [shoulder, side], [stern, side], [stern, -side], [shoulder, -side]]
    }
}

/// Depths and distances to keep.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Safety {
    /// Least charted depth for getting about: draught and under-keel clearance \[m\].
    #[serde(default)]
    pub transit_depth_m: f64,
    /// Least charted depth for informative maneuvers \[m\].
    #[serde(default)]
    pub trial_depth_m: f64,
    /// Distance that the hull keeps from obstacles \[m\].
    pub margin_m: f64,
    /// Bound on the current that is not known \[m/s\].
    #[serde(default)]
    pub unknown_current_m_s: f64,
    /// Relative error that the nominal parameters may have: maneuvers have room for vessels that are off by it.
    #[serde(default)]
    pub parameter_error: f64,
    /// Simulations of the finished plan with such currents and vessels; as many as `aground_probability` needs without it.
    pub runs: Option<u32>,
    /// Vessels that are drawn for them; one per run without it.
    pub vessels: Option<u32>,
    /// The check supports that going aground is less probable than this, 95 % confidence.
    pub aground_probability: Option<f64>,
}

/// A maneuver to place.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ManeuverUse {
    /// Its name in the dictionary.
    pub name: String,
    /// How often; without it, as often as the design's share wants.
    pub count: Option<u32>,
    /// Length of one piece, cut to whole periods where the maneuver has any; all of it without one \[s\].
    pub piece_s: Option<f64>,
}

/// A place and heading.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Place {
    /// Longitude.
    pub longitude_deg: f64,
    /// Latitude.
    pub latitude_deg: f64,
    /// Compass heading.
    pub heading_deg: f64,
    /// Speed mode; at rest without one (or the slowest where there is no rest).
    pub mode: Option<String>,
}

/// Where the trial may end.
#[derive(Clone, Debug, Deserialize)]
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

/// What is minimised.
#[derive(Clone, Copy, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct CostRule {
    /// First.
    pub primary: Primary,
    /// Among plans that are equal in that.
    pub secondary: Secondary,
}

/// What is minimised first.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
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
