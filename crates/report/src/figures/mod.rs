//! Figures of the report as SVG text.
//!
//! Every function takes numbers and labels and returns one whole `<svg>` element. It has a `viewBox` and no fixed
//! size, so it scales to the width of its container; it has no ids and no style sheet, so that several can be on one
//! page. Ink is `currentColor` and follows the page; the other colours are those of [`palette`], which a page may
//! restyle for a dark background by attribute selectors such as `[fill="#0072B2"]`.
//!
//! Values that are not finite are omitted; [`map`] has none. The same input gives the same bytes.

mod axis;
mod bars;
mod correlations;
mod dots;
mod histogram;
pub mod map;
pub mod palette;
mod svg;
pub(crate) mod text;
mod traces;

pub use bars::{ErrorRow, SensitivityRow, ShareRow, relative_errors, sensitivities, shares};
pub use correlations::{CorrelationCell, CorrelationRow, correlations};
pub use dots::{AccuracyCurve, FrontDot, ScoredDot, accuracy, front, scored};
pub use histogram::{Histogram, HistogramAxis, HistogramPanel, histogram_pair};
pub use map::{Map, map_figure};
pub use text::number as tick_number;
pub use traces::{Curve, TraceColumn, TraceRow, TrackCell, TrackLine, traces, tracks};
