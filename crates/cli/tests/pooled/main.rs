//! Pooled estimates, their trust, cross-validation and selection, through the real binaries.

#[path = "../support/mod.rs"]
mod support;

mod constraints;
mod cross;
mod estimate;
mod force_search;
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

/// Pools the runs of the small study; add flags and an output.
pub const POOL: &str = "estimate --structure own --vessel vessel.toml --trajectories campaign.parquet";
/// Cross-validation over a few of its runs.
pub const CROSS: &str = "estimate --structure own --folds each --vessel vessel.toml --trajectories campaign.parquet \
     --runs random/0,random/1,optimized/2,optimized/3 --window-s 25";
/// A selection study on its segments, which are named by maneuver.
pub const SELECTION: &str = "validate selection --vessel vessel.toml --trajectories campaign.parquet --part-s 25 \
     --counts decelerate=2,spiral-fast=2,zig-zag-fast-steep=1 --realizations 40";
