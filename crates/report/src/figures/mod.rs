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

/// Colours that people with the common colour deficiencies can distinguish (Okabe and Ito 2008).
pub mod palette {
    /// Red, green, blue.
    pub type Rgb = (u8, u8, u8);

    /// Text, axes and outlines: written as `currentColor`.
    pub const INK: Rgb = (0, 0, 0);
    /// Of the first series: the optimized experiment.
    pub const BLUE: Rgb = (0x00, 0x72, 0xB2);
    /// Of the second series: the one it is compared with.
    pub const VERMILION: Rgb = (0xD5, 0x5E, 0x00);
    /// Of the third series.
    pub const GREEN: Rgb = (0x00, 0x9E, 0x73);
    /// Of the fourth series.
    pub const PURPLE: Rgb = (0xCC, 0x79, 0xA7);
    /// Of the fifth series.
    pub const AMBER: Rgb = (0xE6, 0x9F, 0x00);

    const SERIES: [Rgb; 5] = [BLUE, VERMILION, GREEN, PURPLE, AMBER];

    /// Colour of series number `index`; they repeat after five.
    #[must_use]
    pub fn series(index: usize) -> Rgb {
        SERIES[index % SERIES.len()]
    }

    /// Colour of input number `index` of a maneuver, distinct from the colours of the first two series.
    #[must_use]
    pub fn input(index: usize) -> Rgb {
        const INPUTS: [Rgb; 5] = [GREEN, PURPLE, AMBER, BLUE, VERMILION];
        INPUTS[index % INPUTS.len()]
    }

    /// As written in SVG: `#0072B2`.
    #[must_use]
    pub fn hex(rgb: Rgb) -> String {
        format!("#{:02X}{:02X}{:02X}", rgb.0, rgb.1, rgb.2)
    }
}
