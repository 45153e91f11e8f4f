//! The crate as its users see it.

mod arranging;
mod campaign;
mod clearance;
mod closed_loop;
mod daylight;
mod deviations;
mod grid;
mod handling;
mod legs;
mod map;
mod moments;
mod navigation;
mod parts;
mod passage_lines;
mod pieces;
mod planner;
mod reacting;
mod rounds;
mod slowed;
mod tide;
