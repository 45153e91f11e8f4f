use refusal::Invalid;

use crate::figures::map::input::Frame;
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

/// The parts of a polyline inside the frame.
pub(crate) fn line(view: &View, points: &[Point]) -> Vec<Vec<Point>> {
    let mut parts: Vec<Vec<Point>> = Vec::new();
    let mut open = false;
    for pair in points.windows(2) {
        let Some((from, to)) = segment(view, pair[0], pair[1]) else {
            open = false;
            continue;
        };
        match parts.last_mut() {
            Some(part) if open => part.push(to),
            _ => parts.push(vec![from, to]),
        }
        open = to == pair[1];
    }
    parts
}

/// The part of a segment inside the frame (Liang and Barsky 1984).
pub(crate) fn segment(view: &View, from: Point, to: Point) -> Option<(Point, Point)> {
    let (low, high) = (view.corner, view.opposite);
    let step = (to.0 - from.0, to.1 - from.1);
    let sides = [
        (-step.0, from.0 - low.0),
        (step.0, high.0 - from.0),
        (-step.1, from.1 - low.1),
        (step.1, high.1 - from.1),
    ];
    let (mut enter, mut leave) = (0.0_f64, 1.0_f64);
    for (outwards, room) in sides {
        if outwards == 0.0 && room < 0.0 {
            return None;
        }
        if outwards < 0.0 {
            enter = enter.max(room / outwards);
        } else if outwards > 0.0 {
            leave = leave.min(room / outwards);
        }
    }
    let at = |share: f64| view.nearest((from.0 + share * step.0, from.1 + share * step.1));
    let start = if enter > 0.0 { at(enter) } else { from };
    let end = if leave < 1.0 { at(leave) } else { to };
    (enter <= leave).then_some((start, end))
}

/// The part of a ring inside the frame, closed along the frame's sides, by clipping at one side at a time.
pub(crate) fn ring(view: &View, ring: &[Point]) -> Vec<Point> {
    let (low, high) = (view.corner, view.opposite);
    let turned = |ring: Vec<Point>| -> Vec<Point> { ring.into_iter().map(|(x, y)| (y, x)).collect() };
    let across = clipped(&clipped(ring, low.0, 1.0), high.0, -1.0);
    turned(clipped(&clipped(&turned(across), low.1, 1.0), high.1, -1.0))
}

/// The part of a ring where `sign * (x - limit)` is not negative.
fn clipped(ring: &[Point], limit: f64, sign: f64) -> Vec<Point> {
    let is_in = |at: Point| sign * (at.0 - limit) >= 0.0;
    let before = ring.iter().cycle().skip(ring.len().saturating_sub(1));
    let mut kept = Vec::with_capacity(ring.len() + 4);
    for (&from, &to) in before.zip(ring) {
        if is_in(from) != is_in(to) {
            kept.push((limit, from.1 + (limit - from.0) / (to.0 - from.0) * (to.1 - from.1)));
        }
        kept.extend(is_in(to).then_some(to));
    }
    kept
}

/// The points of a line that keep it within `tolerance` of itself (Douglas and Peucker 1973).
pub(crate) fn simplified(points: &[Point], tolerance: f64) -> Vec<Point> {
    let Some(last) = points.len().checked_sub(1) else { return Vec::new() };
    let mut kept = vec![false; points.len()];
    kept[0] = true;
    kept[last] = true;
    let mut stretches = vec![(0, last)];
    while let Some((from, to)) = stretches.pop() {
        let inner = from + 1..to;
        let off = |i: usize| (i, distance(points[i], points[from], points[to]));
        let Some((farthest, most)) = inner.map(off).max_by(|a, b| a.1.total_cmp(&b.1)) else { continue };
        if most > tolerance {
            kept[farthest] = true;
            stretches.extend([(from, farthest), (farthest, to)]);
        }
    }
    points.iter().zip(kept).filter_map(|(&point, kept)| kept.then_some(point)).collect()
}

/// Distance of a point from a segment.
fn distance(point: Point, from: Point, to: Point) -> f64 {
    let (along, off) = ((to.0 - from.0, to.1 - from.1), (point.0 - from.0, point.1 - from.1));
    let square = along.0 * along.0 + along.1 * along.1;
    let share = if square > 0.0 { (off.0 * along.0 + off.1 * along.1) / square } else { 0.0 };
    let share = share.clamp(0.0, 1.0);
    libm::hypot(off.0 - share * along.0, off.1 - share * along.1)
}
