//! The crate as its users see it.

mod aborts;
mod clearance;
mod daylight;
mod deviations;
mod follow;
#[path = "../../../trial/tests/all/golden.rs"]
mod golden;
mod grid;
mod handling;
mod lattice;
mod legs;
mod map;
mod navigation;
mod passage_lines;
mod pieces;
mod plan_goldens;
mod plan_laws;
mod plan_refusals;
mod planned;
mod reacting;
mod tide;
mod traffic;
