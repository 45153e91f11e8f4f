//! Tests of this crate, one program.

mod apportioned;
mod correlations;
