//! The one writer of SVG: elements on a sheet, in pixels, as short as they can be written.
//!
//! Coordinates are whole tenths of a pixel; what is not finite is left out.

mod look;
mod path;
mod sheet;
mod units;

pub(crate) use look::{Anchor, Colours, Lettering, Look, Paint};
pub(crate) use path::Path;
pub(crate) use sheet::Sheet;
pub(crate) use units::{Point, units};
