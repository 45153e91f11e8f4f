//! The page of a sweep.

mod axes;
mod data;
mod figures;
mod page;

pub use page::render_sweep;
