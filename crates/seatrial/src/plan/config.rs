//! `plan.toml`.

use std::path::PathBuf;

use serde::Deserialize;
use trial::{Handling, Mode};
use vessel::Invalid;

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
    /// Corners of the lattice.
    pub area: Area,
    /// Charts, all of them at once.
    pub chart: Vec<ChartSpec>,
    /// What uncharted places count as: obstacles as soon as a chart has depths, else water.
    pub uncharted: Option<chart::Uncharted>,
    /// The hull.
    pub hull: HullSpec,
    /// Depths and distances to keep.
    pub safety: Safety,
    /// The current that is known.
    pub known_current: Option<KnownCurrent>,
    /// How the vessel is handled between maneuvers.
    pub handling: Handling,
    /// What comes before and after a maneuver.
    #[serde(default)]
    pub approach: ApproachSpec,
    /// Speeds that the vessel may have at a node, besides being at rest.
    #[serde(default)]
    pub speed_mode: Vec<SpeedMode>,
    /// The maneuvers to place; without any, those of the design.
    #[serde(default)]
    pub maneuver: Vec<ManeuverUse>,
    /// Time in informative maneuvers, for counts that follow from the design's shares \[s\].
    pub informative_s: Option<f64>,
    /// Where the trial begins.
    pub start: Place,
    /// Where it may end.
    pub goal: GoalSpec,
    /// What is minimised.
    #[serde(default)]
    pub cost: CostSpec,
}

/// Name of the mode of a vessel that is held in place.
pub(super) const AT_REST: &str = "at rest";

fn raster_per_cell() -> usize {
    4
}

/// Corners of the lattice in degrees.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Area {
    /// Western edge.
    pub west_deg: f64,
    /// Southern edge.
    pub south_deg: f64,
    /// Eastern edge.
    pub east_deg: f64,
    /// Northern edge.
    pub north_deg: f64,
}

/// One chart.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ChartSpec {
    /// GeoJSON (`.geojson`, `.json`) or ESRI ASCII grid (`.asc`), relative to this file.
    pub file: PathBuf,
    /// What it shows.
    pub kind: ChartKind,
    /// Its coordinates; GeoJSON is always in WGS84.
    pub crs: Option<String>,
    /// Property with the least depth of an area.
    #[serde(default = "least")]
    pub least: String,
    /// Property with its greatest depth, for drawing.
    #[serde(default = "greatest")]
    pub greatest: String,
    /// Only these features.
    pub only: Option<chart::Filter>,
    /// A grid of open sea, without land or missing cells.
    #[serde(default)]
    pub open_sea: bool,
}

fn least() -> String {
    "DRVAL1".to_owned()
}

fn greatest() -> String {
    "DRVAL2".to_owned()
}

/// What a chart shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ChartKind {
    /// Polygons of land, or a grid of 1 (land) and 0 (water of unknown depth).
    Land,
    /// Polygons to keep out of.
    NoGo,
    /// Depth areas, or a grid of depths, positive down.
    Depth,
    /// A grid of elevations, negative down.
    Elevation,
}

/// The hull in the horizontal plane: a rectangle with a pointed bow.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct HullSpec {
    /// Length over all \[m\].
    pub length_m: f64,
    /// Beam \[m\].
    pub beam_m: f64,
    /// Distance of the reference point forward of the middle \[m\].
    #[serde(default)]
    pub reference_m: f64,
}

impl HullSpec {
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
    /// Simulations of the finished plan with such currents.
    #[serde(default = "check_runs")]
    pub runs: u32,
}

fn check_runs() -> u32 {
    64
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
}

impl Default for ApproachSpec {
    fn default() -> Self {
        Self { run_in_s: 30.0, tolerance_cells: 0.1, tolerance_deg: 6.0 }
    }
}

/// A speed that the vessel may have at a node.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SpeedMode {
    /// Its name.
    pub name: String,
    /// Surge speed \[m/s\].
    pub speed_m_s: f64,
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
pub enum GoalSpec {
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
pub struct CostSpec {
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
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
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

impl PlanFile {
    /// Refuses numbers without meaning.
    ///
    /// # Errors
    /// Names the key.
    pub fn check(&self) -> Result<(), Invalid> {
        self.handling.check()?;
        let positive = [
            ("cell_m", self.cell_m),
            ("hull.length_m", self.hull.length_m),
            ("hull.beam_m", self.hull.beam_m),
            ("approach.tolerance_cells", self.approach.tolerance_cells),
            ("approach.tolerance_deg", self.approach.tolerance_deg),
            ("informative_s", self.informative_s.unwrap_or(1.0)),
        ];
        let not_negative = [
            ("safety.margin_m", self.safety.margin_m),
            ("safety.transit_depth_m", self.safety.transit_depth_m),
            ("safety.trial_depth_m", self.safety.trial_depth_m),
            ("safety.unknown_current_m_s", self.safety.unknown_current_m_s),
            ("safety.parameter_error", self.safety.parameter_error),
            ("approach.run_in_s", self.approach.run_in_s),
            ("known_current.speed_m_s", self.known_current.map_or(0.0, |c| c.speed_m_s)),
        ];
        let bad = |(key, value): &(&str, f64), least: f64, expected: &str| {
            let fine = value.is_finite() && (*value > least || (least < 0.0 && *value >= 0.0));
            (!fine).then(|| Invalid::new(format!("`{key}`"), value.to_string(), expected, "correct it"))
        };
        let refused = positive.iter().find_map(|p| bad(p, 0.0, "a number above 0"));
        let refused =
            refused.or_else(|| not_negative.iter().find_map(|p| bad(p, -1.0, "a number from 0 up")));
        match refused {
            Some(invalid) => Err(invalid),
            None => self.check_choices().and_then(|()| self.check_ranges()),
        }
    }

    fn check_choices(&self) -> Result<(), Invalid> {
        if ![4, 8, 16].contains(&self.headings) {
            return Err(Invalid::new("`headings`", self.headings.to_string(), "4, 8 or 16", "correct it"));
        }
        if self.raster_per_cell == 0 || self.raster_per_cell % 2 == 1 || self.raster_per_cell > 64 {
            let found = self.raster_per_cell.to_string();
            return Err(Invalid::new(
                "`raster_per_cell`",
                found,
                "an even number from 2 to 64",
                "correct it",
            ));
        }
        if self.safety.trial_depth_m < self.safety.transit_depth_m {
            return Err(Invalid::new(
                "`safety.trial_depth_m`",
                self.safety.trial_depth_m.to_string(),
                format!("at least the transit depth, {}", self.safety.transit_depth_m),
                "informative maneuvers need the deeper water",
            ));
        }
        let a = self.area;
        let ordered = a.west_deg < a.east_deg && a.south_deg < a.north_deg;
        if !ordered || a.west_deg < -180.0 || a.east_deg > 180.0 || a.south_deg < -90.0 || a.north_deg > 90.0
        {
            let found = format!("{} to {} E, {} to {} N", a.west_deg, a.east_deg, a.south_deg, a.north_deg);
            return Err(Invalid::new(
                "`area`",
                found,
                "west below east, south below north, in degrees",
                "correct it",
            ));
        }
        let slow = self.speed_mode.iter().find(|m| !(m.speed_m_s.is_finite() && m.speed_m_s > 0.0));
        match slow {
            Some(mode) => Err(Invalid::new(
                format!("speed mode `{}`", mode.name),
                format!("{} m/s", mode.speed_m_s),
                "a speed above 0 m/s",
                "being at rest is always there where the vessel can hold it: leave it out",
            )),
            None => Ok(()),
        }
    }

    /// The speed modes, slowest first; at rest first of all where the vessel can turn on the spot.
    pub fn modes(&self, can_hold: bool) -> Vec<Mode> {
        let rest = can_hold.then(|| Mode { name: AT_REST.to_owned(), speed_m_s: 0.0 });
        let own = self.speed_mode.iter().map(|m| Mode { name: m.name.clone(), speed_m_s: m.speed_m_s });
        let mut modes: Vec<Mode> = rest.into_iter().chain(own).collect();
        modes.sort_by(|a, b| a.speed_m_s.total_cmp(&b.speed_m_s));
        modes
    }
}

impl Primary {
    /// As in the file.
    pub fn name(self) -> &'static str {
        ["basic-moves", "seconds"][self as usize]
    }
}

impl Secondary {
    /// As in the file.
    pub fn name(self) -> &'static str {
        ["seconds", "turns", "clearance"][self as usize]
    }
}
