use crate::figures::palette;
use crate::figures::svg::{Look, Paint};

pub use study::documents::{MapPurpose as Purpose, MapSymbol as Symbol};

/// The contents of a map. Positions are `[x, y]` in metres, x east, y north.
#[derive(Clone, Debug, Default)]
pub struct Map {
    /// Accessible name: `Planned trial off Helsinki`.
    pub title: String,
    /// Accessible description: for readers who cannot see the map.
    pub description: String,
    /// Written across the top of a map whose plan must not be followed.
    pub warning: Option<String>,
    /// The part of the plane that is drawn.
    pub frame: Frame,
    /// Whether positions without an area or a cell are uncharted; else they are water, of a chart that shows only
    /// land.
    pub uncharted: bool,
    /// Limits between the shades of depth \[m\], increasing, at most twelve; empty for a single shade.
    pub depth_limits_m: Vec<f64>,
    /// A raster of classes, below the areas.
    pub cells: Option<Cells>,
    /// Polygons.
    pub areas: Vec<ChartedArea>,
    /// Depth contours.
    pub contours: Vec<Contour>,
    /// Cells that only the safety margin blocks, drawn in this order.
    pub margins: Vec<Margin>,
    /// Charted points.
    pub spots: Vec<Spot>,
    /// Names and their positions; the first ones have priority if there is little space.
    pub names: Vec<([f64; 2], String)>,
    /// The area swept by simulated vessels.
    pub tube: Option<Tube>,
    /// The corridor of each leg of the passage, a ring.
    pub corridors: Vec<Vec<[f64; 2]>>,
    /// The area that the hull is kept in, if it is not a box: a ring.
    pub edge: Vec<[f64; 2]>,
    /// Areas with a speed limit, as rings.
    pub speed_limits: Vec<Vec<[f64; 2]>>,
    /// The informative maneuvers, each with its number of uses; their order is that of the colours.
    pub maneuvers: Vec<(String, u64)>,
    /// Lines.
    pub tracks: Vec<PlottedTrack>,
    /// Abort tracks.
    pub aborts: Vec<Vec<[f64; 2]>>,
    /// Outlines of the hull at chosen poses.
    pub hulls: Vec<Vec<[f64; 2]>>,
    /// The start of the trial.
    pub start: Option<[f64; 2]>,
    /// Its end.
    pub goal: Option<[f64; 2]>,
    /// Labels along the frame.
    pub graticule: Graticule,
}

/// A rectangle \[m\].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    /// Least x.
    pub west: f64,
    /// Least y.
    pub south: f64,
    /// Greatest x.
    pub east: f64,
    /// Greatest y.
    pub north: f64,
}

impl Default for Frame {
    /// A square kilometre north-east of the origin.
    fn default() -> Self {
        Self { west: 0.0, south: 0.0, east: 1000.0, north: 1000.0 }
    }
}

/// The class of an area or a cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Class {
    /// Land.
    Land,
    /// Water that may not be entered.
    NoGo,
    /// Water.
    Depth {
        /// Its least depth \[m\]; negative if it dries.
        least_m: f64,
    },
}

/// A polygon with holes. Rings may be closed or open, in either direction.
#[derive(Clone, Debug, PartialEq)]
pub struct ChartedArea {
    /// Its class.
    pub class: Class,
    /// Outer ring.
    pub ring: Vec<[f64; 2]>,
    /// Inner rings.
    pub holes: Vec<Vec<[f64; 2]>>,
}

/// A depth contour.
#[derive(Clone, Debug, PartialEq)]
pub struct Contour {
    /// Its depth \[m\], if known.
    pub depth_m: Option<f64>,
    /// Its points in order.
    pub line: Vec<[f64; 2]>,
}

/// Square cells. Cell (0, 0) is the south-western one; columns run east, rows run north.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Raster {
    /// South-western corner of cell (0, 0) \[m\].
    pub origin: [f64; 2],
    /// Side of a cell \[m\].
    pub cell_m: f64,
    /// Columns.
    pub nx: usize,
    /// Rows.
    pub ny: usize,
}

/// A raster of classes.
#[derive(Clone, Debug, PartialEq)]
pub struct Cells {
    /// The raster of the cells.
    pub grid: Raster,
    /// One class per cell, in rows from south to north; `None` if uncharted.
    pub classes: Vec<Option<Class>>,
}

/// Cells that only the safety margin blocks.
#[derive(Clone, Debug, PartialEq)]
pub struct Margin {
    /// Its purpose: in pale red for transit, hatched for trial.
    pub purpose: Purpose,
    /// The raster of the cells.
    pub grid: Raster,
    /// One value per cell.
    pub blocked: Vec<bool>,
}

/// A charted point.
#[derive(Clone, Debug, PartialEq)]
pub struct Spot {
    /// Its position.
    pub at: [f64; 2],
    /// Its style.
    pub symbol: Symbol,
    /// Depth over it \[m\].
    pub depth_m: Option<f64>,
    /// Its title.
    pub title: String,
}

/// Cells that hulls swept.
#[derive(Clone, Debug, PartialEq)]
pub struct Tube {
    /// The raster of the cells.
    pub grid: Raster,
    /// One value per cell.
    pub swept: Vec<bool>,
    /// Number of simulated vessels.
    pub vessels: u64,
}

/// The style of a line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TrackStyle {
    /// In the colour of maneuver number `0`, `1`, … of [`Map::maneuvers`].
    Maneuver(usize),
    /// A basic move: grey.
    Basic,
    /// A run-in before a maneuver: thin.
    RunIn,
    /// One of many realizations: very thin. At most 200 are drawn, evenly chosen; the legend has the total.
    Realization,
}

/// A line.
#[derive(Clone, Debug, PartialEq)]
pub struct PlottedTrack {
    /// Its style.
    pub style: TrackStyle,
    /// Its points in order; less than two draw nothing.
    pub points: Vec<[f64; 2]>,
    /// Number of the step, shown at the first point.
    pub number: Option<u64>,
}

/// Labels along the frame, as longitudes and latitudes. Those outside the frame are omitted.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Graticule {
    /// Positions x \[m\] with their labels, below the frame.
    pub x: Vec<(f64, String)>,
    /// Positions y \[m\] with their labels, left of the frame.
    pub y: Vec<(f64, String)>,
}

/// Ink on the map, which stays light on a dark page.
pub(crate) const DARK: Paint = Paint::solid((0x1d, 0x24, 0x2b));
pub(crate) const WHITE: Paint = Paint::solid((0xff, 0xff, 0xff));
/// Water of unknown depth: greener than every shade of depth.
const WATER: Paint = Paint::solid((0xdd, 0xef, 0xec));
/// Water of the only shade.
const PLAIN: Paint = Paint::solid((0xd9, 0xe9, 0xf5));
const UNCHARTED: Paint = Paint::solid((0xe3, 0xe3, 0xdf));
const SHALLOW: (f64, f64, f64) = (143.0, 194.0, 229.0);
const DEEP: (f64, f64, f64) = (240.0, 247.0, 252.0);
const SAND: Paint = Paint::solid((0xe2, 0xc5, 0x9c));
const SHORE: Paint = Paint::solid((0x76, 0x55, 0x2e));
const FORBIDDEN: Paint = Paint::solid((0xe6, 0xcf, 0xe6));
const FORBIDDEN_EDGE: Paint = Paint::solid((0xa0, 0x20, 0x80));
pub(crate) const DANGER: Paint = Paint::solid((0xc8, 0x28, 0x1e));
const PALE_RED: Paint = Paint::solid((0xf6, 0xbd, 0xb4));
/// Okabe and Ito's yellow.
const YELLOW: Paint = Paint::solid((0xf0, 0xe4, 0x42));
const VIOLET: Paint = Paint::solid((0x7b, 0x3a, 0xa8));
const GREY: Paint = Paint::solid((0x62, 0x66, 0x6a));
const FINE: f64 = 0.7;

pub(crate) const fn background(uncharted: bool) -> Look {
    Look::filled(if uncharted { UNCHARTED } else { WATER })
}

/// Shade number `band` of `bands`, from the shoalest: the shoaler, the bluer. A border of its own colour covers the
/// seam to the next.
pub(crate) fn depth(band: usize, bands: usize) -> Look {
    let paint = match bands {
        0 | 1 => PLAIN,
        _ => Paint::solid(between(band as f64 / (bands - 1) as f64)),
    };
    Look::filled(paint).outlined(paint, 0.5)
}

fn between(share: f64) -> (u8, u8, u8) {
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "between two colours")]
    let mix = |from: f64, to: f64| (from + share * (to - from)).round() as u8;
    (mix(SHALLOW.0, DEEP.0), mix(SHALLOW.1, DEEP.1), mix(SHALLOW.2, DEEP.2))
}

pub(crate) const LAND: Look = Look::filled(SAND).outlined(SHORE, FINE);
pub(crate) const NO_GO: Look = Look::filled(FORBIDDEN).outlined(FORBIDDEN_EDGE, 1.2).dashed(5.0, 3.0);

/// Fill and border of a margin.
pub(crate) const fn margin(purpose: Purpose) -> Look {
    match purpose {
        Purpose::Transit => Look::filled(PALE_RED.faded(0.85)).outlined(DANGER.faded(0.7), FINE),
        Purpose::Trial => Look::drawn(DANGER.faded(0.65), FINE).dashed(2.5, 2.0),
    }
}

pub(crate) const HATCH: Look = Look::drawn(DANGER.faded(0.5), FINE);

/// The halo below a track, which makes it stand out.
pub(crate) const fn halo(width: f64) -> Look {
    Look::drawn(WHITE.faded(0.85), width)
}

/// Width of the line of a maneuver.
pub(crate) const MANEUVER: f64 = 3.2;

/// Colours of maneuver `index`: its line and, beyond the palette's five, a line within it.
pub(crate) fn maneuver(index: usize) -> (Look, Option<Look>) {
    let line = Look::drawn(maneuver_paint(index), MANEUVER);
    let within = match index / 5 % 3 {
        0 => None,
        1 => Some(Look::drawn(WHITE, 1.1)),
        _ => Some(Look::drawn(DARK, 1.1)),
    };
    (line, within)
}

pub(crate) fn maneuver_paint(index: usize) -> Paint {
    Paint::solid(palette::series(index))
}

/// A depth contour and its value.
pub(crate) const CONTOUR_PAINT: Paint = Paint::solid((0x4f, 0x7f, 0xab));
pub(crate) const CONTOUR: Look = Look::drawn(CONTOUR_PAINT, FINE);
pub(crate) const DEPTH_DIGITS: Paint = Paint::solid((0x3d, 0x55, 0x6b));
pub(crate) const DANGER_CIRCLE: Look =
    Look::filled(Paint::solid((0xbf, 0xdc, 0xee))).outlined(DARK, 0.9).dashed(1.2, 1.6);

/// The area swept by simulated vessels.
pub(crate) const TUBE: Look = Look::filled(DARK.faded(0.16)).outlined(DARK.faded(0.45), 0.6);
/// The edge of an area that is not a box.
pub(crate) const EDGE: Look = Look::drawn(DARK, 1.3).dashed(7.0, 3.0);
/// Areas with a speed limit.
pub(crate) const SPEED_LIMIT: Look = Look::drawn(FORBIDDEN_EDGE.faded(0.9), 1.2).dashed(1.5, 2.5);
/// The corridor of a leg.
pub(crate) const CORRIDOR: Look = Look::drawn(VIOLET.faded(0.75), 0.8).dashed(4.0, 2.5);

/// An abort track.
pub(crate) const ABORT: Look = Look::drawn(DANGER.faded(0.85), 1.0).dashed(5.0, 3.0);

pub(crate) const BASIC: Look = Look::drawn(GREY, 2.0);
pub(crate) const RUN_IN: Look = Look::drawn(DARK, 1.0);

/// One of `drawn` realizations: the more there are, the fainter each.
pub(crate) fn realization(drawn: usize) -> Look {
    let opacity = (8.0 / drawn.max(1) as f64).clamp(0.05, 0.4);
    Look::drawn(DARK.faded((100.0 * opacity).round() / 100.0), 0.6)
}

pub(crate) const HULL: Look = Look::filled(WHITE.faded(0.35)).outlined(DARK, 0.9);
pub(crate) const START: Look = Look::filled(YELLOW).outlined(DARK, 1.2);
pub(crate) const GOAL: Look = Look::filled(VIOLET).outlined(WHITE, 1.2);
