//! `plan.toml`.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use chart::{Crs, GridDeclaration, GridKind, LayerKind};
use files::Error;
use plan::voyage::{AbortRule, CostRule, Goal, Hull, ManeuverUse, Place, Safety, SpeedLimit};
use plan::{Mode, Sensors, StatedHandling};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use ship::engine::{Changes, ChangingCurrent, MOST_CURRENT_M_S, Measurement, Wind};

/// `plan.toml` as written.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PlanFile {
    /// Name of the trial in routes; without it, that of the folder.
    pub name: Option<String>,
    /// Distance of neighbouring nodes of the lattice \[m\].
    #[schemars(range(max = 1e6), extend("exclusiveMinimum" = 0.0))]
    pub cell_m: f64,
    /// Heading levels: 4, 8 or 16.
    pub headings: usize,
    /// Raster cells per lattice cell, even: how finely the chart and the hull's swept area are compared.
    #[serde(default = "raster_per_cell")]
    pub raster_per_cell: usize,
    /// The area that the ship may use; the lattice covers it.
    #[serde(skip_serializing)]
    pub area: AreaSpec,
    /// Charts, all of them at once.
    pub chart: Vec<ChartSpec>,
    /// How uncharted positions count: as obstacles if a chart has depths, else as water.
    #[serde(skip_serializing)]
    pub uncharted: Option<chart::Uncharted>,
    /// The hull.
    pub hull: Hull,
    /// Depths and distances to keep.
    pub safety: Safety,
    /// The known current.
    pub known_current: Option<KnownCurrent>,
    /// The handling of the vessel between maneuvers, unless it follows from the vessel.
    #[serde(default, skip_serializing)]
    pub handling: StatedHandling,
    /// The approach before and the tolerances after a maneuver.
    #[serde(default)]
    pub approach: ApproachSpec,
    /// The accuracy of the ship's sensors.
    #[serde(default)]
    pub sensors: SensorSpec,
    /// The noise of what is logged, as in campaign.toml: of a ship with forces, whose information is weighed by it.
    pub measurement: Option<Measurement>,
    /// How the current changes while the ship sails.
    pub changing_current: Option<ChangingCurrent>,
    /// Gusts.
    pub wind: Option<Wind>,
    /// Speeds of the vessel at a node, besides rest.
    #[serde(default, skip_serializing)]
    pub speed_mode: Vec<Mode>,
    /// Speed limits in parts of the area.
    #[serde(default)]
    pub speed_limit: Vec<SpeedLimit>,
    /// What the traffic's directions ask.
    #[serde(default)]
    pub traffic: TrafficSpec,
    /// The maneuvers to place; without any, those of the design.
    #[serde(default)]
    pub maneuver: Vec<ManeuverUse>,
    /// Time in informative maneuvers, for counts that follow from the design's shares \[s\].
    #[schemars(range(max = 1e9), extend("exclusiveMinimum" = 0.0))]
    pub informative_s: Option<f64>,
    /// When the trial begins, as `2026-06-01T08:00:00Z` or with an offset; without it nothing has times of day.
    #[serde(skip_serializing)]
    pub departure: Option<String>,
    /// When the trial may take place.
    #[serde(skip_serializing)]
    pub slot: Option<SlotSpec>,
    /// Level and stream of the water over time.
    #[serde(skip_serializing)]
    pub tide: Option<TideSpec>,
    /// The start of the trial.
    #[serde(skip_serializing)]
    pub start: Place,
    /// Its possible ends.
    #[serde(skip_serializing)]
    pub goal: Goal,
    /// The cost that is minimised.
    #[serde(default, skip_serializing)]
    pub cost: CostRule,
    /// Whether every leg needs a way to water where she may wait, if it fails.
    #[serde(default = "told", skip_serializing)]
    pub abort: AbortRule,
    /// For how long it is told how she drifts with her engine stopped \[s\].
    #[serde(default = "abort_drift_s")]
    #[schemars(range(min = 1.0, max = 7200.0))]
    pub abort_drift_s: f64,
    /// Room around her where she waits, besides hull and margin; without it that of her slowest circle, and at least her length
    /// \[m\].
    #[schemars(range(min = 0.0, max = 1e4))]
    pub abort_room_m: Option<f64>,
}

impl PlanFile {
    /// How current and wind change.
    pub(super) fn changes(&self) -> Changes {
        Changes { current: self.changing_current, wind: self.wind }
    }
}

fn raster_per_cell() -> usize {
    4
}

fn told() -> AbortRule {
    AbortRule::Told
}

fn abort_drift_s() -> f64 {
    600.0
}

/// The area that the ship may use: a box, or a polygon.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct AreaSpec {
    /// Western edge of the box; east of the eastern one if it is across the antimeridian.
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
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ChartSpec {
    /// GeoJSON (`.geojson`, `.json`), grid (`.asc`, GeoTIFF `.tif`) or cell of an electronic chart (`.000`), or the folder or `CATALOG.031` of several, relative to this file.
    pub file: PathBuf,
    /// Its contents; a cell has objects of many classes.
    #[serde(skip_serializing)]
    pub kind: Option<ChartKind>,
    /// Its coordinates, if not in the file; GeoJSON is always in WGS84.
    pub crs: Option<String>,
    /// The unit of its depths, elevations or depths over dangers, if not in the file: m, dm, cm, mm, km, ft, us-ft or
    /// fathom; metres without it.
    #[serde(skip_serializing)]
    pub depth_unit: Option<chart::DepthUnit>,
    /// Property with the least depth of an area (`DRVAL1`), or with the depth over a danger (`VALSOU`).
    pub least: Option<String>,
    /// The radius of danger at its points and lines \[m\]; 50 without it.
    #[schemars(range(max = 1e4), extend("exclusiveMinimum" = 0.0))]
    pub radius_m: Option<f64>,
    /// The same for objects with a doubtful position \[m\]; 500 without it.
    #[schemars(range(max = 1e4), extend("exclusiveMinimum" = 0.0))]
    pub doubtful_radius_m: Option<f64>,
    /// Classes of an electronic chart with other than the default rules.
    #[serde(default, skip_serializing)]
    pub rules: BTreeMap<String, chart::Treatment>,
    /// Only these features.
    #[serde(skip_serializing)]
    pub only: Option<chart::Filter>,
    /// A grid of open sea, without land or missing cells; or a chart of land without land nearby.
    #[serde(default)]
    pub open_sea: bool,
}

/// The contents of a chart.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum ChartKind {
    /// Land and islets, or a grid of 1 (land) and 0 (water of unknown depth).
    Land,
    /// Keep out.
    NoGo,
    /// Wrecks, rocks and obstructions: obstacles unless the depth over them is known and sufficient.
    Danger,
    /// Depth areas, or a grid of depths, positive down.
    Depth,
    /// A grid of elevations, negative down.
    Elevation,
    /// Objects of an electronic chart, each by the rule of its class: a cell, or GeoJSON that GDAL made of one.
    Objects,
}

/// A table of tides, and when the trial has to be over.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TideSpec {
    /// CSV with the columns `time` (as `departure`), `level_m` over the chart's datum, and `stream_m_s`,
    /// `towards_deg` if the stream is known; relative to this file.
    pub file: PathBuf,
    /// When the trial has to be over.
    pub until: String,
}

/// When the trial may take place, by the keys that are given.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SlotSpec {
    /// It begins then or later (written as `departure`).
    pub from: Option<String>,
    /// It is over by then (written as `departure`).
    pub until: Option<String>,
    /// It takes place between sunrise and sunset at the area's centre.
    #[serde(default)]
    pub daylight: bool,
}

/// A current, by its set.
#[derive(Clone, Copy, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct KnownCurrent {
    /// Speed \[m/s\].
    #[schemars(range(min = 0.0, max = MOST_CURRENT_M_S))]
    pub speed_m_s: f64,
    /// Compass direction that it sets towards.
    #[schemars(range(min = -360.0, max = 360.0))]
    pub towards_deg: f64,
}

/// The approach before and the tolerances after a maneuver.
#[derive(Clone, Copy, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct ApproachSpec {
    /// Steady approach \[s\].
    #[schemars(range(min = 0.0, max = 1e4))]
    pub run_in_s: f64,
    /// Largest distance from the node at the end of a leg, as a fraction of the cell.
    #[schemars(range(max = 1e3), extend("exclusiveMinimum" = 0.0, "x-unit" = "cells"))]
    pub tolerance_cells: f64,
    /// Largest difference of heading at the end of a leg.
    #[schemars(range(max = 360.0), extend("exclusiveMinimum" = 0.0))]
    pub tolerance_deg: f64,
    /// Largest difference of speed at the end of a leg, and in sway besides the currents \[m/s\]; 0.1 without it.
    #[schemars(range(max = 100.0), extend("exclusiveMinimum" = 0.0))]
    pub tolerance_m_s: Option<f64>,
    /// Largest yaw rate at the end of a leg \[rad/s\]; 15 % of the turn rate without it.
    #[schemars(range(max = 10.0), extend("exclusiveMinimum" = 0.0, "x-unit" = "rad/s"))]
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

/// What the directions of a chart's traffic lanes ask.
#[derive(Clone, Copy, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct TrafficSpec {
    /// How far from a right angle the ship may cross a lane, or a zone between lanes.
    #[schemars(range(min = 0.0, max = 45.0))]
    pub crossing_deg: f64,
}

impl Default for TrafficSpec {
    fn default() -> Self {
        Self { crossing_deg: 20.0 }
    }
}

/// Standard deviations of the ship's measurements; 0 if exact.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct SensorSpec {
    /// Position, north and east each \[m\].
    #[schemars(range(min = 0.0, max = 1e6))]
    pub position_m: f64,
    /// Heading \[degrees\].
    #[schemars(range(min = 0.0, max = 360.0))]
    pub heading_deg: f64,
    /// Speeds u and v \[m/s\].
    #[schemars(range(min = 0.0, max = 100.0))]
    pub speed_m_s: f64,
    /// Yaw rate \[rad/s\].
    #[schemars(range(min = 0.0, max = 10.0))]
    pub yaw_rate_rad_s: f64,
}

impl From<SensorSpec> for Sensors {
    fn from(sensor_spec: SensorSpec) -> Self {
        let SensorSpec { position_m, heading_deg, speed_m_s, yaw_rate_rad_s } = sensor_spec;
        Self { position_m, heading_rad: heading_deg.to_radians(), speed_m_s, yaw_rate_rad_s }
    }
}

// The keys of a `[[chart]]`, and which of them apply to its file.

/// Property with the least depth of an area, and with the depth over a danger, in electronic charts (S-57).
const LEAST: &str = "DRVAL1";
const OVER: &str = "VALSOU";

impl ChartSpec {
    /// Refuses keys that do not apply to such a file.
    pub(super) fn check_keys(&self, path: &Path, is_cell: bool) -> Result<(), Error> {
        let objects = is_cell || self.kind == Some(ChartKind::Objects);
        let refuse = |thing: &str, found: &str, expected: &str, remedy: &str| {
            Err(Error::refuse(path, thing, found, expected, remedy))
        };
        if is_cell && self.kind.is_some_and(|kind| kind != ChartKind::Objects) {
            let expected = "none, or `objects`: a cell shows objects of many classes";
            return refuse(
                "`kind`",
                "another kind, of a cell",
                expected,
                "leave it out, and say in `rules` what differs",
            );
        }
        if objects && (self.least.is_some() || self.only.is_some() || self.crs.is_some()) {
            let expected = "`rules`, `radius_m`, `doubtful_radius_m` only";
            return refuse("[[chart]]", "`least`, `only` or `crs`, of objects", expected, "leave them out");
        }
        if !objects && (!self.rules.is_empty() || self.doubtful_radius_m.is_some()) {
            let expected = "a cell (`.000`), or `kind = \"objects\"`";
            return refuse("[[chart]]", "`rules` or `doubtful_radius_m`", expected, "leave them out");
        }
        let measures =
            [ChartKind::Depth, ChartKind::Elevation, ChartKind::Danger].map(Some).contains(&self.kind);
        if let Some(unit) = self.depth_unit.filter(|_| !measures) {
            let given = format!("`{}`, of a chart without depths of its own unit", unit.name());
            let expected = "`kind` of depth, elevation or danger; objects say their unit themselves";
            return refuse("`depth_unit`", &given, expected, "leave it out");
        }
        if !objects && self.kind.is_none() {
            let expected = "land, no-go, depth, danger, elevation or objects";
            return refuse(
                "`kind`",
                "none",
                expected,
                "say what the file shows; cells (`.000`) need no kind",
            );
        }
        Ok(())
    }

    /// The kind of the polygons of a file.
    pub(super) fn layer_kind(&self, path: &Path) -> Result<LayerKind, Error> {
        let is_near = |name: &&str| Crs::new(name).is_ok_and(|crs| crs.is_near_wgs84());
        if let Some(crs) = self.crs.as_deref().filter(|name| !is_near(name)) {
            let remedy = "leave `crs` out, or transform the file with `ogr2ogr -t_srs EPSG:4326`";
            let expected = "WGS84, as all GeoJSON is (RFC 7946), or degrees within a metre or two of it";
            return Err(Error::refuse(path, "`crs`", crs, expected, remedy));
        }
        let named = |usual: &str| self.least.clone().unwrap_or_else(|| usual.to_owned());
        match self.kind {
            Some(ChartKind::Land) => Ok(LayerKind::Land),
            Some(ChartKind::NoGo) => Ok(LayerKind::NoGo),
            Some(ChartKind::Depth) => Ok(LayerKind::Depth { least: named(LEAST) }),
            Some(ChartKind::Danger) => Ok(LayerKind::Danger { least: named(OVER) }),
            _ => Err(Error::refuse(
                path,
                "`kind`",
                "elevation, of polygons",
                "land, no-go, depth, danger or objects",
                "elevations come as a grid (.asc, .tif)",
            )),
        }
    }

    /// The declaration of a grid.
    pub(super) fn grid(&self, path: &Path) -> Result<GridDeclaration, Error> {
        let kind = match self.kind {
            Some(ChartKind::Land) => GridKind::LandMask,
            Some(ChartKind::Depth) => GridKind::Depth,
            Some(ChartKind::Elevation) => GridKind::Elevation,
            other => {
                let given =
                    format!("{}, of a grid", if other == Some(ChartKind::NoGo) { "no-go" } else { "danger" });
                let expected = "land, depth or elevation";
                return Err(Error::refuse(path, "`kind`", given, expected, "draw it as a polygon"));
            }
        };
        if let Some(radius_m) = self.radius_m {
            let (found, expected) = (format!("{radius_m} m, of a grid"), "none: it is for points and lines");
            return Err(Error::refuse(path, "`radius_m`", found, expected, "leave it out"));
        }
        let crs = self.crs.as_deref().map(Crs::new).transpose().map_err(|e| Error::invalid(path, e))?;
        Ok(GridDeclaration { kind, crs, unit: self.depth_unit, open_sea: self.open_sea })
    }
}
