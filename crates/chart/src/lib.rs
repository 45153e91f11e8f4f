//! Sea charts: polygons and grids on a local plane, obstacles and clearance for a ship's hull, output of routes and tracks.
//!
//! Not for navigation. Coordinates on the plane are x east and y north \[m\]; headings are compass headings (0 north,
//! clockwise) \[rad\]; longitude comes before latitude, in degrees of WGS84; depths are positive down \[m\].
//!
//! Objects of electronic charts (S-57) come from the crate `enc`, each judged by the rule of its class
//! ([`RULES`]). GDAL converts a cell to GeoJSON, one object class at a time:
//!
//! ```text
//! ogr2ogr -f GeoJSON depare.geojson US5WA22M.000 DEPARE
//! ```
//!
//! Depths are in DEPARE and DRGARE (`DRVAL1`, `DRVAL2`), land in LNDARE, PONTON and HULKES, dangers in
//! OBSTRN, WRECKS and UWTROC (`VALSOU`), most of them points. Lakes of GSHHG are polygons of their own
//! (`level` 2): read as land, like the land around them, they are correctly closed to the ship.
//!
//! ```
//! use chart::{Bounds, Chart, Footprint, Layer, LayerKind, Obstacles, Plane, PolygonLayer, Raster};
//!
//! let island = r#"{"type": "Polygon", "coordinates":
//!     [[[24.95, 60.10], [24.96, 60.10], [24.96, 60.11], [24.95, 60.11], [24.95, 60.10]]]}"#;
//! let land = PolygonLayer::from_geojson(island, &LayerKind::Land, None)?;
//! let area = Bounds::new([-2000.0, -2000.0], [2000.0, 2000.0])?;
//! let chart = Chart::new(Plane::new(24.955, 60.105)?, area.grown(200.0), &[Layer::Polygons(land)], None)?;
//! let obstacles = Obstacles::new(&chart, Raster::covering(&area, 25.0)?, 0.0, 100.0)?;
//! let hull = [[50.0, 0.0], [-50.0, 10.0], [-50.0, -10.0]];
//! let ahead = Footprint::swept(&hull, &[(0.0, 0.0, 0.0), (0.0, 300.0, 0.0)], 25.0)?;
//! assert!(obstacles.is_free(&ahead, 20, 20));
//! assert!(!obstacles.is_free(&ahead, 80, 60));
//! # Ok::<(), chart::Invalid>(())
//! ```

#![forbid(unsafe_code)]
#![warn(missing_docs)]

mod chart;
mod classes;
mod crs;
mod dangers;
pub mod enc;
mod footprint;
mod grid;
mod grid_cells;
mod grid_tiff;
mod grid_tiff_metadata;
mod objects;
mod obstacles;
mod occupancy;
mod placed;
mod plane;
mod polygons;
mod reading;
pub mod ring;
pub mod route;
mod rules;
mod traffic;

pub use chart::{Chart, Layer, Uncharted};
pub use classes::{Called, Ignored, Judged, RULES, Rule, Treatment};
pub use crs::{Crs, DepthUnit, UnitFrom};
pub use dangers::{Closing, Dangers, Nearest};
pub use footprint::{Footprint, Run};
pub use grid::{Grid, GridCell, GridDeclaration, GridKind, Measured};
pub use grid_tiff_metadata::{Direction, TiffMetadata};
pub use objects::{Tallies, Tally, objects_of_geojson, read_objects};
pub use obstacles::{Distances, Obstacles};
pub use occupancy::{Causes, Mask};
pub use placed::{PlacedGrid, Polygon, Spot};
pub use plane::{Bounds, Plane, Raster};
pub use polygons::{Area, Class, Contour, DANGER_M, Filter, LayerKind, Mark, Noted, PolygonLayer};
pub use reading::{Reading, Unread};
pub use refusal::Invalid;
pub use rules::{DOUBTFUL_M, Rules};
pub use traffic::Traffic;
