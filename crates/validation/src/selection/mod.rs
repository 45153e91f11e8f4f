//! Models from sub-experiments that a design picked, against random picks of the same number.

mod counts;
mod draw;
mod prepared;
mod realize;
mod scores;
mod select;

pub use counts::available;
pub use realize::Realization;
pub use scores::{DEGENERATE, PublishedLimits, SelectionErrors, SelectionScores, SharesBeyond};
pub use select::{Selection, SelectionOptions, Selector};
