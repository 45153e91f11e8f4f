//! Models from sub-experiments that a design picked, against random picks of the same number.

mod counts;
mod draw;
mod prepared;
mod realize;
mod select;

pub use counts::{apportioned, available};
pub use realize::Realization;
pub use select::{DEGENERATE, Selected, Selection, SelectionOptions, select};
