//! Linear algebra on small dense square blocks (2 to about 20 rows), row-major in slices.
//!
//! The LU kernels work in place and allocate nothing, for use in hot loops: a general library spends most of its time on
//! such blocks in set-up. They are checked against faer, which does everything else.

#![forbid(unsafe_code)]
#![warn(missing_docs)]

pub mod distributions;
mod instructions;
mod lu;
mod product;
pub mod statistics;
mod weakest;

pub use instructions::{dispatch, dispatch_narrow, missing_instructions};
pub use lu::{LogDet, condition, inverse, inverse_and_log_det, inverse_in_order, log_det, one_norm, solve};
pub use product::{add_outer, add_rows, congruence, dot, product, quadratic, times, transposed};
pub use weakest::{Weakest, weakest};
