use std::collections::BTreeMap;

use artifact::{Digest, Document, Units};
use identification::Estimator;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::Value;

/// `cells.json`: the cells of a sweep's grid, and what is set in each.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CellsDocument {
    /// Folder of the study's hand-written files, seen from that of sweep.toml.
    pub study: String,
    /// The maneuvers, seen from there.
    pub dictionary: String,
    /// What is varied.
    pub axes: Vec<SweepAxis>,
    /// Parts that each cell's runs are shared between.
    pub shards: u32,
    /// The line that others are compared with; null for the first of each tally.
    pub baseline: Option<SweepLine>,
    /// Flags of `moments`.
    pub moments: Vec<String>,
    /// Flags of `design`.
    pub design: Vec<String>,
    /// Flags of `monte-carlo`, for every cell.
    pub monte_carlo: Vec<String>,
    /// Cells of the same vessel and maneuvers share a design.
    pub designs: Vec<SweepDesign>,
    /// The cells, the last axis running fastest.
    pub cells: Vec<SweepCell>,
}

/// An axis of the grid.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SweepAxis {
    /// The dotted key, which begins with the file's name.
    pub key: String,
    /// Its values.
    pub values: Vec<Value>,
}

/// What is made of runs of one design by one estimator.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SweepLine {
    /// The design.
    pub design: String,
    /// The estimator.
    pub estimator: Estimator,
}

/// A design that cells share.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SweepDesign {
    /// Name of its folder.
    pub name: String,
    /// `--set` for `moments`: of the vessel, and of the campaign where the ship has forces.
    pub vessel: Vec<String>,
    /// `--set` for those that read the vessel and the maneuvers.
    pub dictionary: Vec<String>,
}

/// A cell of the grid.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SweepCell {
    /// Name of its folder.
    pub name: String,
    /// The place of its value on each axis, from 0.
    pub at: Vec<usize>,
    /// `--set` for the stages that read all of the study's files.
    pub set: Vec<String>,
    /// Name of its design.
    pub design: String,
    /// Digests of the study's files with what is set in them.
    pub inputs: BTreeMap<String, Digest>,
    /// Why there is no such cell; null where there is.
    pub refused: Option<String>,
}

impl Document for CellsDocument {
    const ID: &'static str = "cells";
    const VERSION: u32 = 1;
    const UNITS: Units = &[("1", "shards at"), ("that of the key", "values")];
}
