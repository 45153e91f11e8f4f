use super::view::View;
use crate::figures::svg::Point;

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
