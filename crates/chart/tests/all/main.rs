//! Charts as they are read, what they leave free, and routes.

mod dangers;
mod depth_units;
mod directions;
mod enc;
mod footprints;
mod geodesy;
mod grid_files;
mod grid_formats;
mod marks;
mod masks;
mod objects;
mod obstacles;
mod orientation;
mod polygon_files;
mod real_charts;
mod routes;
mod support;
mod tiff_metadata;
mod traffic;
mod xml;
