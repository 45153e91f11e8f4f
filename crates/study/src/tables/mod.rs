//! The tables of a study: the columns of each beside the type of its rows.

pub mod estimates;
pub mod moments_table;
pub mod resamples;
pub mod scores;
pub mod selection;
pub mod track;
pub mod trajectories;
