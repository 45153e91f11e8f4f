use serde::Deserialize;

use crate::{Grid, PolygonLayer};

/// What the polygons of a file are.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum LayerKind {
    /// Land, piers, pontoons: whatever is never water.
    Land,
    /// Water that the plan keeps out of.
    NoGo,
    /// Areas of a known range of depths.
    Depth {
        /// Property with the least depth \[m, positive down\], such as `DRVAL1`. A feature where it is null
        /// has an unknown depth and is an obstacle.
        least: String,
        /// Property with the greatest depth \[m\], such as `DRVAL2`: for drawing only.
        #[serde(default)]
        greatest: Option<String>,
    },
}

/// Which features of a file belong to the layer: those whose `property` is one of `values`.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Filter {
    /// The property, such as `objl`.
    pub property: String,
    /// Its values as text (`DEPARE`, or `42` where the file has numbers).
    pub values: Vec<String>,
}

/// What a polygon is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Class {
    /// Land.
    Land,
    /// Keep out.
    NoGo,
    /// Water between two depths \[m, positive down\].
    Depth {
        /// Least depth; `None`: unknown, an obstacle at every least depth asked for.
        least_m: Option<f64>,
        /// Greatest depth, where known.
        greatest_m: Option<f64>,
    },
}

/// What places that no layer charts are.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Uncharted {
    /// Unknown water is not safe: the default of charts with a depth layer.
    Obstacle,
    /// Water is whatever is not land or no-go: the default of charts without depths.
    Water,
}

/// One layer of a chart.
#[derive(Clone, Debug)]
pub enum Layer {
    /// Polygons in longitude and latitude.
    Polygons(PolygonLayer),
    /// A grid in a declared CRS.
    Grid(Grid),
}
