//! Matrices, statistics and distributions against laws, faer and exact sums.

mod decompositions;
mod distributions;
mod intervals;
mod lu;
mod product;
mod statistics;
