//! Properties of searches for the structure of a model.

mod compact_intervals;
mod draws;
mod pairs;
mod wind;
