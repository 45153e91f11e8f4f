//! What must hold of searches for the structure of a model.

mod compact_intervals;
