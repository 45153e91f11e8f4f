//! The SVG writer: elements on a sheet, in pixels, in their shortest form.
//!
//! Coordinates are whole tenths of a pixel; values that are not finite are omitted.

mod look;
mod path;
mod sheet;
mod units;

pub(crate) use look::{Anchor, Colours, Lettering, Look, Paint};
pub(crate) use path::Path;
pub(crate) use sheet::Sheet;
pub(crate) use units::{Point, units};
