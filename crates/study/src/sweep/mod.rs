//! A study whose hand-written values are varied over a grid: `sweep.toml`, its cells, and their summary.

mod collected;
mod file;
mod grid;

pub use collected::collected;
pub use file::SweepFile;
pub use grid::cells;
