//! Linear algebra on dense matrices, row-major in slices; lanes of runs; statistics; steps of searches.
//!
//! Small square blocks (2 to about 20 rows) are eliminated in place, without allocation, for use in hot loops: a general library
//! spends most of its time on such blocks in set-up. faer does everything else: larger systems, singular values, eigenvalues.

#![forbid(unsafe_code)]
#![warn(missing_docs)]

pub mod bounded;
mod lane;
pub mod lanes;
pub mod least_squares;
mod lu;
mod product;
pub mod statistics;
#[doc(hidden)]
pub mod vectorized;

pub use bounded::{Watch, iterate};
pub use lane::{Arithmetic, GROUPS, LANES, Lane, Number, Numbers, Row, Wide};
pub use lu::{
    LogDet, Weakest, condition, inverse, inverse_and_log_det, inverse_in_order, log_det, one_norm,
    scaled_inverse, solve, symmetric, weakest,
};
pub use product::{
    add_outer, add_rows, congruence, dependent_columns, dot, product, quadratic, quadratic_of_inverse, times,
    transposed,
};
pub use vectorized::{dispatch, dispatch_narrow, missing_instructions};
