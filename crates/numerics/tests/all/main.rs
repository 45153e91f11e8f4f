//! Matrices, statistics and distributions against laws, faer and exact sums.

mod bounded;
mod decompositions;
mod distributions;
mod intervals;
mod iterations;
mod least_squares;
mod lu;
mod product;
mod semidefinite;
mod statistics;
