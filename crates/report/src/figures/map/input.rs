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
    pub areas: Vec<Area>,
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
    pub tracks: Vec<Track>,
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
pub struct Area {
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

/// The purpose of a margin.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Purpose {
    /// Passing through: drawn in pale red.
    Transit,
    /// Informative maneuvers: drawn hatched.
    Trial,
}

/// Cells that only the safety margin blocks.
#[derive(Clone, Debug, PartialEq)]
pub struct Margin {
    /// Its purpose.
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

/// How a charted point is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Symbol {
    /// As a depth.
    Sounding,
    /// As an object to keep clear of.
    Danger,
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
pub struct Track {
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
