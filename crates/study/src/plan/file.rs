//! `plan.toml`.

use std::collections::BTreeMap;
use std::path::PathBuf;

use serde::Deserialize;
use trial::voyage::{CostRule, Goal, Hull, ManeuverUse, Place, Safety, SpeedLimit};
use trial::{Mode, StatedHandling};

/// `plan.toml` as written.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PlanFile {
    /// Distance of neighbouring nodes of the lattice \[m\].
    pub cell_m: f64,
    /// Heading levels: 4, 8 or 16.
    pub headings: usize,
    /// Raster cells per lattice cell, even: how finely the chart and the hull's swept area are compared.
    #[serde(default = "raster_per_cell")]
    pub raster_per_cell: usize,
    /// Where the ship may sail; the lattice covers it.
    pub area: AreaSpec,
    /// Charts, all of them at once.
    pub chart: Vec<ChartSpec>,
    /// What uncharted places count as: obstacles as soon as a chart has depths, else water.
    pub uncharted: Option<chart::Uncharted>,
    /// The hull.
    pub hull: Hull,
    /// Depths and distances to keep.
    pub safety: Safety,
    /// The current that is known.
    pub known_current: Option<KnownCurrent>,
    /// How the vessel is handled between maneuvers, as far as it does not follow from the vessel.
    #[serde(default)]
    pub handling: StatedHandling,
    /// What comes before and after a maneuver.
    #[serde(default)]
    pub approach: ApproachSpec,
    /// What the ship's sensors can tell apart.
    #[serde(default)]
    pub sensors: SensorSpec,
    /// Speeds that the vessel may have at a node, besides being at rest.
    #[serde(default)]
    pub speed_mode: Vec<Mode>,
    /// Speeds that are not exceeded in parts of the area.
    #[serde(default)]
    pub speed_limit: Vec<SpeedLimit>,
    /// The maneuvers to place; without any, those of the design.
    #[serde(default)]
    pub maneuver: Vec<ManeuverUse>,
    /// Time in informative maneuvers, for counts that follow from the design's shares \[s\].
    pub informative_s: Option<f64>,
    /// When the trial begins, as `2026-06-01T08:00:00Z` or with an offset; without it nothing has times of day.
    pub departure: Option<String>,
    /// When the trial may take place.
    pub slot: Option<SlotSpec>,
    /// Level and stream of the water over time.
    pub tide: Option<TideSpec>,
    /// Where the trial begins.
    pub start: Place,
    /// Where it may end.
    pub goal: Goal,
    /// What is minimised.
    #[serde(default)]
    pub cost: CostRule,
}

fn raster_per_cell() -> usize {
    4
}

/// Where the ship may sail: a box, or a polygon.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AreaSpec {
    /// Western edge of the box; east of the eastern one where it lies across the antimeridian.
    pub west_deg: Option<f64>,
    /// Southern edge of the box.
    pub south_deg: Option<f64>,
    /// Eastern edge of the box.
    pub east_deg: Option<f64>,
    /// Northern edge of the box.
    pub north_deg: Option<f64>,
    /// Instead of the box: longitude and latitude of a polygon's corners, in their order, either way round \[deg\].
    pub corners: Option<Vec<[f64; 2]>>,
}

/// One chart.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ChartSpec {
    /// GeoJSON (`.geojson`, `.json`), grid (`.asc`, GeoTIFF `.tif`, NetCDF `.nc`) or cell of an electronic chart (`.000`), or
    /// the folder or `CATALOG.031` of several, relative to this file.
    pub file: PathBuf,
    /// What it shows; a cell shows objects of many classes.
    pub kind: Option<ChartKind>,
    /// Its coordinates, where the file does not say; GeoJSON is always in WGS84.
    pub crs: Option<String>,
    /// The variable of a NetCDF file with depths or elevations, where it has several.
    pub variable: Option<String>,
    /// Property with the least depth of an area (`DRVAL1`), or with the depth over a danger (`VALSOU`).
    pub least: Option<String>,
    /// How far around its points and lines the danger reaches \[m\]; 50 without it.
    pub radius_m: Option<f64>,
    /// The same where a chart's object has a doubtful position \[m\]; 500 without it.
    pub doubtful_radius_m: Option<f64>,
    /// Classes of an electronic chart that are treated otherwise than usual.
    #[serde(default)]
    pub rules: BTreeMap<String, chart::Treatment>,
    /// Only these features.
    pub only: Option<chart::Filter>,
    /// A grid of open sea, without land or missing cells; or a chart of land that has none near.
    #[serde(default)]
    pub open_sea: bool,
}

/// What a chart shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ChartKind {
    /// Land and islets, or a grid of 1 (land) and 0 (water of unknown depth).
    Land,
    /// Keep out.
    NoGo,
    /// Wrecks, rocks and obstructions: obstacles unless the depth over them is known and enough.
    Danger,
    /// Depth areas, or a grid of depths, positive down.
    Depth,
    /// A grid of elevations, negative down.
    Elevation,
    /// Objects of an electronic chart, each by the rule of its class: a cell, or GeoJSON that GDAL made of one.
    Objects,
}

/// A table of tides, and when the trial has to be over.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TideSpec {
    /// CSV with the columns `time` (as `departure`), `level_m` over the chart's datum, and `stream_m_s`, `towards_deg` where the
    /// stream is known; relative to this file.
    pub file: PathBuf,
    /// When the trial has to be over.
    pub until: String,
}

/// When the trial may take place: as far as each key says.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SlotSpec {
    /// It begins then or later (written as `departure`).
    pub from: Option<String>,
    /// It is over by then (written as `departure`).
    pub until: Option<String>,
    /// It takes place between sunrise and sunset at the area's middle.
    #[serde(default)]
    pub daylight: bool,
}

/// A current, by where it sets.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct KnownCurrent {
    /// Speed \[m/s\].
    pub speed_m_s: f64,
    /// Compass direction that it sets towards.
    pub towards_deg: f64,
}

/// What comes before and after a maneuver.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ApproachSpec {
    /// Steady approach \[s\].
    pub run_in_s: f64,
    /// Largest distance from the node at the end of a leg, as a fraction of the cell.
    pub tolerance_cells: f64,
    /// Largest difference of heading at the end of a leg.
    pub tolerance_deg: f64,
    /// Largest difference of speed at the end of a leg, and in sway besides the currents \[m/s\]; 0.1 without it.
    pub tolerance_m_s: Option<f64>,
    /// Largest yaw rate at the end of a leg \[rad/s\]; 15 % of the turn rate without it.
    pub tolerance_rad_s: Option<f64>,
}

impl Default for ApproachSpec {
    fn default() -> Self {
        Self {
            run_in_s: 30.0,
            tolerance_cells: 0.1,
            tolerance_deg: 6.0,
            tolerance_m_s: None,
            tolerance_rad_s: None,
        }
    }
}

/// Standard deviations of what the ship measures on its way; 0 of what is exact.
#[derive(Clone, Copy, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct SensorSpec {
    /// Position, north and east each \[m\].
    pub position_m: f64,
    /// Heading \[degrees\].
    pub heading_deg: f64,
    /// Speeds u and v \[m/s\].
    pub speed_m_s: f64,
    /// Yaw rate \[rad/s\].
    pub yaw_rate_rad_s: f64,
}
