use chart::{Bounds, clip_ring};

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

/// The part of a ring inside the frame, closed along the frame's sides.
pub(crate) fn ring(view: &View, ring: &[Point]) -> Vec<Point> {
    let (low, high) = (view.corner, view.opposite);
    let frame = Bounds { min: [low.0, low.1], max: [high.0, high.1] };
    let ring: Vec<[f64; 2]> = ring.iter().map(|&(x, y)| [x, y]).collect();
    clip_ring(&ring, &frame).into_iter().map(|[x, y]| (x, y)).collect()
}
