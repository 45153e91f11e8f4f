//! Pooled estimates, their trust, cross-validation and selection, through the real binaries.

#[path = "../support/mod.rs"]
mod support;

mod constraints;
mod cross;
mod estimate;
mod forces;
mod golden;
mod model;
mod moments;
mod real;
mod refusals;
mod search;
mod selection;
mod single;
mod undeclared;
mod units;

use serde_json::{Value, json};
use tempfile::TempDir;

use support::*;

/// Pools the runs of the small study; add flags and an output.
pub const POOL: &str = "estimate --structure own --vessel vessel.toml --trajectories campaign.parquet";
/// Cross-validation over a few of its runs.
pub const CROSS: &str = "estimate --structure own --folds each --vessel vessel.toml --trajectories campaign.parquet \
     --runs random/0,random/1,optimized/2,optimized/3 --window-s 25";
/// A selection study on its segments, which are named by maneuver.
pub const SELECTION: &str = "validate --vessel vessel.toml --trajectories campaign.parquet --design picks.json --realizations 40 --allow=mixed";

/// Writes `lists` as [candidates] of vessel.toml, in place of those that it has; nothing removes them.
pub fn candidates(folder: &TempDir, lists: &str) {
    let text = std::fs::read_to_string(folder.path().join("vessel.toml")).unwrap();
    let ship = text.split("\n[candidates]").next().unwrap();
    let table = if lists.is_empty() { String::new() } else { format!("\n[candidates]\n{lists}") };
    put(folder, "vessel.toml", &format!("{ship}{table}"));
}

/// A folder with these segments, and a design that picks five of them.
pub fn picking() -> TempDir {
    let folder = with(&["campaign.parquet", "design.json"]);
    pick(&folder, json!({"decelerate": 2, "spiral-fast": 2, "zig-zag-fast-steep": 1}));
    folder
}

/// Writes picks.json, the design of design.json with these `counts`.
pub fn pick(folder: &TempDir, counts: Value) {
    let mut design = json(folder, "design.json");
    design["seal"] = Value::Null;
    design["data"]["counts"] = counts;
    put(folder, "picks.json", &design.to_string());
}
