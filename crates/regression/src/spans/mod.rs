//! Passes over the samples for any model, span by span: branches per term are taken once for all samples of a span.

mod columns;
mod regressors;
mod residuals;
mod signals;
mod squares;

pub(crate) use columns::{Kept, add_instruments, add_measured};
pub(crate) use residuals::put_residuals;
pub(crate) use squares::add_squares;
