//! A plan on the chart: `map.json`.

use std::collections::BTreeMap;

use files::{Document, Units};
use refusal::Invalid;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// `map.json`: a planned trial on its chart, for whoever draws it again.
///
/// Places are metres east and north of an origin, on the plane on which directions and distances from the origin are true
/// (azimuthal equidistant, WGS84). What comes later in lists lies above.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MapDocument {
    /// Whether the plan passes its own check.
    pub safe: bool,
    /// The plan in words.
    pub statement: String,
    /// Uses of every informative maneuver.
    pub counts: BTreeMap<String, u64>,
    /// Longitude of the origin.
    pub longitude_deg: f64,
    /// Latitude of the origin.
    pub latitude_deg: f64,
    /// What part of the plane is shown.
    pub frame: MapFrame,
    /// Whether water is where nothing is charted; else such places are an obstacle.
    pub uncharted_is_water: bool,
    /// Limits between shades of depth \[m\], increasing; none where no depth is charted.
    pub depth_limits_m: Vec<f64>,
    /// Cells of gridded charts, below all areas.
    pub cells: Option<MapCells>,
    /// Areas of the chart, cut to the frame.
    pub areas: Vec<MapArea>,
    /// Lines of one depth.
    pub contours: Vec<MapContour>,
    /// Cells that are blocked by their depth or by the margin alone.
    pub margins: Vec<MapMargin>,
    /// Charted points.
    pub spots: Vec<MapSpot>,
    /// Names of areas, the largest first.
    pub names: Vec<MapName>,
    /// What hulls sweep in the runs of the check that are kept; absent without any.
    pub swept: Option<MapSwept>,
    /// The corridor of each leg of the passage, as wide as its cross-track distances; rings.
    pub corridors: Vec<MapLine>,
    /// The area that the hull is kept in, a ring; absent where that is the frame.
    pub edge: Option<MapLine>,
    /// Where speed is limited, rings.
    pub speed_limits: Vec<MapLine>,
    /// The nominal track in parts.
    pub tracks: Vec<MapTrack>,
    /// Abort tracks from the ends of legs.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub aborts: Vec<MapLine>,
    /// The outline of the hull where maneuvers begin, rings.
    pub hulls: Vec<MapLine>,
    /// Where the trial begins.
    pub start: Option<MapPlace>,
    /// Where it ends.
    pub goal: Option<MapPlace>,
    /// Longitudes of the graticule with their places.
    pub meridians: Vec<MapMeridian>,
    /// Latitudes of the graticule with their places.
    pub parallels: Vec<MapParallel>,
}

/// A rectangle.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MapFrame {
    /// Its western side.
    pub west_m: f64,
    /// Its southern side.
    pub south_m: f64,
    /// Its eastern side.
    pub east_m: f64,
    /// Its northern side.
    pub north_m: f64,
}

/// A place.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MapPlace {
    /// East of the origin.
    pub east_m: f64,
    /// North of the origin.
    pub north_m: f64,
}

/// Places in their order; the last of a ring is joined with the first.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MapLine {
    /// East of the origin.
    pub east_m: Vec<f64>,
    /// North of the origin, as many.
    pub north_m: Vec<f64>,
}

refusal::choices! {
    /// What an area or a cell is.
    pub enum MapClass {
        /// Land.
        Land = "land",
        /// Water that may not be entered.
        NoGo = "no-go",
        /// Water of a least depth.
        Depth = "depth",
    }
}

/// A polygon.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MapArea {
    /// What it is.
    pub class: MapClass,
    /// Its least depth, negative where it dries; of water alone.
    pub least_m: Option<f64>,
    /// The outer ring, then the holes.
    pub rings: Vec<MapLine>,
}

/// A line of one depth.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MapContour {
    /// Its depth, where it is known.
    pub depth_m: Option<f64>,
    /// The line.
    pub line: MapLine,
}

/// Square cells: columns from west to east, rows from south to north.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MapRaster {
    /// Western side of the first column.
    pub west_m: f64,
    /// Southern side of the first row.
    pub south_m: f64,
    /// Side of a cell.
    pub cell_m: f64,
    /// Columns.
    pub columns: u64,
    /// Rows.
    pub rows: u64,
}

/// Some cells of a raster, row by row from the south: lengths of runs of cells that are alternately out and in, out first.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(transparent)]
pub struct MapRuns(pub Vec<u64>);

/// Cells of gridded charts.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MapCells {
    /// Where the cells are.
    pub raster: MapRaster,
    /// Land, and water of each shade; a cell of none is on no grid.
    pub classes: Vec<MapCellClass>,
}

/// Cells of one class.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MapCellClass {
    /// What they are.
    pub class: MapClass,
    /// The least depth of any of them; of water alone.
    pub least_m: Option<f64>,
    /// Which they are.
    pub runs: MapRuns,
}

refusal::choices! {
    /// What a margin is kept for.
    pub enum MapPurpose {
        /// Informative maneuvers.
        Trial = "trial",
        /// Passing through.
        Transit = "transit",
    }
}

/// Cells that are blocked by their depth or by the margin alone.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MapMargin {
    /// For what.
    pub purpose: MapPurpose,
    /// Where the cells are.
    pub raster: MapRaster,
    /// Which are blocked.
    pub runs: MapRuns,
}

/// Cells that hulls sweep.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MapSwept {
    /// Vessels that sail.
    pub vessels: u64,
    /// Where the cells are.
    pub raster: MapRaster,
    /// Which are swept.
    pub runs: MapRuns,
}

refusal::choices! {
    /// How a charted point is drawn.
    pub enum MapSymbol {
        /// As a depth.
        Sounding = "sounding",
        /// As a thing that is kept clear of.
        Danger = "danger",
    }
}

/// A charted point.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MapSpot {
    /// Where it is.
    pub place: MapPlace,
    /// How it is drawn.
    pub symbol: MapSymbol,
    /// Depth over it, where it is known.
    pub depth_m: Option<f64>,
    /// What it is, with its name and depth.
    pub title: String,
}

/// A name.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MapName {
    /// Where it stands.
    pub place: MapPlace,
    /// The name.
    pub name: String,
}

refusal::choices! {
    /// What a part of the track is.
    pub enum MapTrackKind {
        /// An informative maneuver.
        Maneuver = "maneuver",
        /// What leads to a maneuver, and away from it.
        RunIn = "run-in",
        /// A basic move.
        Basic = "basic",
    }
}

/// A part of the nominal track.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MapTrack {
    /// What it is.
    pub kind: MapTrackKind,
    /// Name of the maneuver that is run, or run in to.
    pub maneuver: Option<String>,
    /// Number of a maneuver among all that are run, from 1.
    pub number: Option<u64>,
    /// Up to where the next part begins.
    pub line: MapLine,
}

/// A longitude of the graticule.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MapMeridian {
    /// The longitude.
    pub longitude_deg: f64,
    /// Where it is, half-way up the frame.
    pub east_m: f64,
}

/// A latitude of the graticule.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MapParallel {
    /// The latitude.
    pub latitude_deg: f64,
    /// Where it is, half-way across the frame.
    pub north_m: f64,
}

/// Maximum number of cells of a raster, as for reading charts.
const MOST_CELLS: u64 = 200_000_000;

impl MapDocument {
    /// All lines and rings.
    fn lines(&self) -> impl Iterator<Item = &MapLine> {
        let rings = self.areas.iter().flat_map(|area| &area.rings);
        let lines = self.contours.iter().map(|c| &c.line).chain(self.tracks.iter().map(|track| &track.line));
        let others = self.corridors.iter().chain(&self.edge).chain(&self.speed_limits).chain(&self.hulls);
        rings.chain(lines).chain(others)
    }

    /// All sets of cells with their rasters.
    fn masks(&self) -> impl Iterator<Item = (&MapRaster, &MapRuns)> {
        let cells = self.cells.iter().flat_map(|c| c.classes.iter().map(|class| (&c.raster, &class.runs)));
        let margins = self.margins.iter().map(|margin| (&margin.raster, &margin.runs));
        cells.chain(margins).chain(self.swept.iter().map(|swept| (&swept.raster, &swept.runs)))
    }

    /// Cells of all rasters, with repetitions.
    pub fn raster_cells(&self) -> f64 {
        self.masks().map(|(raster, _)| raster.columns as f64 * raster.rows as f64).sum()
    }
}

impl Document for MapDocument {
    const ID: &'static str = "map";
    const VERSION: u32 = 1;
    const UNITS: Units = &[
        ("m", "east_m north_m west_m south_m cell_m depth_limits_m least_m depth_m"),
        ("deg", "longitude_deg latitude_deg"),
        ("1", "counts number columns rows runs vessels"),
    ];

    fn check(&self) -> Result<(), Invalid> {
        let remedy = "run `plan` again";
        if let Some(line) = self.lines().find(|line| line.east_m.len() != line.north_m.len()) {
            let [found, expected] = [&line.north_m, &line.east_m].map(|p| format!("{} places", p.len()));
            return Err(Invalid::new("`north_m`", found, format!("{expected}, as of `east_m`"), remedy));
        }
        let filled = |(raster, runs): &(&MapRaster, &MapRuns)| {
            let cells = runs.0.iter().try_fold(0_u64, |sum, run| sum.checked_add(*run));
            let right = |cells: &u64| *cells <= MOST_CELLS && raster.cell_m > 0.0;
            cells.filter(right).is_some_and(|cells| raster.columns.checked_mul(raster.rows) == Some(cells))
        };
        if let Some((raster, runs)) = self.masks().find(|mask| !filled(mask)) {
            let given = format!("{} runs that do not fill the raster", runs.0.len());
            let expected =
                format!("runs of {} × {} cells, at most {MOST_CELLS}", raster.columns, raster.rows);
            return Err(Invalid::new("`runs`", given, expected, remedy));
        }
        let strange = self.tracks.iter().filter_map(|track| track.maneuver.as_ref());
        if let Some(name) = strange.into_iter().find(|name| !self.counts.contains_key(*name)) {
            return Err(Invalid::new("`maneuver`", format!("`{name}`"), "a name in `counts`", remedy));
        }
        Ok(())
    }
}
