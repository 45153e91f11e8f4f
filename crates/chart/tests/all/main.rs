//! Charts as they are read, what they leave free, and routes.

mod dangers;
mod footprints;
mod geodesy;
mod grid_files;
mod grid_formats;
mod marks;
mod masks;
mod objects;
mod obstacles;
mod polygon_files;
mod real_charts;
mod routes;
mod support;
mod xml;
