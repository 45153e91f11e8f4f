//! Passes over the samples for any model, span by span: branches per term are taken once for all samples of a span.

mod columns;
mod regressors;
mod signals;
mod squares;

pub(crate) use columns::{Kept, add_instruments, add_measured};
pub(crate) use squares::{add_squares, put_residuals};
