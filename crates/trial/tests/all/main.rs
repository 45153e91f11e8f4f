//! The crate as its users see it.

mod arranging;
mod campaign;
mod clearance;
mod closed_loop;
mod daylight;
mod deviations;
mod golden;
mod grid;
mod handling;
mod legs;
mod map;
mod moments;
mod navigation;
mod parts;
mod passage_lines;
mod pieces;
mod plan_goldens;
mod plan_laws;
mod plan_refusals;
mod planned;
mod planner;
mod reacting;
mod rounds;
mod slowed;
mod studied;
mod tide;
