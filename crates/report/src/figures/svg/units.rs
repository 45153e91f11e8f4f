/// A point of the drawing, in its own pixels: x to the right, y down.
pub(crate) type Point = (f64, f64);

/// Units of the SVG per pixel: whole numbers are short.
const FINENESS: f64 = 10.0;
/// Coordinates are clipped at this many pixels.
const FARTHEST: f64 = 1e6;

/// Whole units of the SVG.
pub(crate) fn units(pixels: f64) -> i64 {
    #[expect(clippy::cast_possible_truncation, reason = "clamped to a range that fits")]
    let units = (pixels.clamp(-FARTHEST, FARTHEST) * FINENESS).round() as i64;
    units
}

/// Whether a point can be drawn.
pub(crate) fn finite(point: &Point) -> bool {
    point.0.is_finite() && point.1.is_finite()
}
