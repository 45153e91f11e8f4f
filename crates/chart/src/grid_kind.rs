//! What a grid is declared to contain.

use serde::Deserialize;

use crate::{Crs, DepthUnit};

/// The quantity in a grid.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum GridKind {
    /// Depths, positive down: charts.
    Depth,
    /// Elevations, negative down: GEBCO, EMODnet and the like.
    Elevation,
    /// 1 is land, 0 is water of unknown depth.
    LandMask,
}

/// Farther from the sea's surface than any ground \[m\]: such numbers mean no data in files that do not
/// declare it.
pub(crate) const FARTHEST: f64 = 12_000.0;

/// How a grid file is to be read.
#[derive(Clone, Debug)]
pub struct GridDeclaration {
    /// What its numbers are.
    pub kind: GridKind,
    /// The CRS of its coordinates, if the file does not state it.
    pub crs: Option<Crs>,
    /// The unit of its depths or elevations, if the file does not state it; metres by default.
    pub unit: Option<DepthUnit>,
    /// Set where the area really is open sea, without land, drying or missing cells: otherwise a grid of only
    /// depths is refused, because it may be elevations of land.
    pub open_sea: bool,
}
