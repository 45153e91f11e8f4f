use refusal::Invalid;

use super::input::Frame;
use crate::figures::svg::Point;

/// Width of the figure \[px\]: on a phone its text is two thirds as large.
pub(crate) const WIDTH: f64 = 560.0;
/// Size of the legend's text [px]: legible if the whole figure is 390 pixels wide.
pub(crate) const LABEL: f64 = 14.5;
/// Size of the text along the frame [px].
pub(crate) const NOTE: f64 = 13.5;
/// Space left of the frame \[px\], for labels written upwards.
const LEFT: f64 = 26.0;
const RIGHT: f64 = 4.0;
const TOP: f64 = 4.0;
const TALLEST: f64 = 760.0;
/// Sides of a frame [m].
const SIDES: std::ops::RangeInclusive<f64> = 1e-2..=1e8;
const MOST_ELONGATED: f64 = 20.0;

/// Refuses frames that cannot be drawn to scale.
fn check(Frame { west, south, east, north }: &Frame) -> Result<(), Invalid> {
    let (width, height) = (east - west, north - south);
    let refused = |expected: &str, remedy: &str| {
        Err(Invalid::new("map: frame", format!("{width} m × {height} m"), expected, remedy))
    };
    if !(SIDES.contains(&width) && SIDES.contains(&height)) {
        let expected = "sides of 0.01 m to 100000 km, east above west and north above south";
        return refused(expected, "correct the frame");
    }
    if width.max(height) > MOST_ELONGATED * width.min(height) {
        return refused("sides within 20 to 1", "widen the frame across its long side");
    }
    Ok(())
}

/// The map's place on the sheet: metres to pixels, the same scale along both axes.
pub(crate) struct View {
    pub(crate) frame: Frame,
    /// Pixels per metre.
    pub(crate) scale: f64,
    /// Upper left corner of the frame.
    pub(crate) corner: Point,
    /// Lower right corner of the frame.
    pub(crate) opposite: Point,
}

impl View {
    /// The largest view that fits the sheet.
    ///
    /// # Errors
    /// A frame without area, an absurdly large or a very long one.
    pub(crate) fn new(frame: &Frame) -> Result<Self, Invalid> {
        check(frame)?;
        let room = WIDTH - LEFT - RIGHT;
        let (width, height) = (frame.east - frame.west, frame.north - frame.south);
        let scale = (room / width).min(TALLEST / height);
        let left = LEFT + 0.5 * (room - scale * width);
        let opposite = (left + scale * width, TOP + scale * height);
        Ok(Self { frame: *frame, scale, corner: (left, TOP), opposite })
    }

    pub(crate) fn place(&self, at: [f64; 2]) -> Point {
        (
            self.corner.0 + self.scale * (at[0] - self.frame.west),
            self.corner.1 + self.scale * (self.frame.north - at[1]),
        )
    }

    pub(crate) fn placed(&self, points: &[[f64; 2]]) -> Vec<Point> {
        points.iter().map(|&at| self.place(at)).collect()
    }

    /// Whether a pixel is inside the frame by at least `inset` pixels.
    pub(crate) fn holds(&self, at: Point, inset: f64) -> bool {
        let (low, high) = (self.corner, self.opposite);
        at.0 >= low.0 + inset && at.0 <= high.0 - inset && at.1 >= low.1 + inset && at.1 <= high.1 - inset
    }

    /// The pixel of the frame nearest to `at`.
    pub(crate) fn nearest(&self, at: Point) -> Point {
        (at.0.clamp(self.corner.0, self.opposite.0), at.1.clamp(self.corner.1, self.opposite.1))
    }
}
