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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::figures::map::Frame;

    fn area(ring: &[Point]) -> f64 {
        let next = ring.iter().cycle().skip(1);
        0.5 * ring.iter().zip(next).map(|(a, b)| a.0 * b.1 - b.0 * a.1).sum::<f64>().abs()
    }

    #[test]
    fn law_a_clipped_ring_has_the_area_inside_the_frame() {
        let view = View::new(&Frame { west: 0.0, south: 0.0, east: 100.0, north: 100.0 });
        let diamond = view.placed(&[[50.0, -50.0], [150.0, 50.0], [50.0, 150.0], [-50.0, 50.0]]);
        let inside = area(&ring(&view, &diamond)) / view.scale.powi(2);
        assert!((inside - 10_000.0).abs() < 1e-6, "{inside}");
        let corner = view.placed(&[[-10.0, -10.0], [30.0, -10.0], [-10.0, 30.0]]);
        let inside = area(&ring(&view, &corner)) / view.scale.powi(2);
        assert!((inside - 200.0).abs() < 1e-6, "{inside}");
        assert!(ring(&view, &view.placed(&[[200.0, 0.0], [300.0, 0.0], [200.0, 9.0]])).is_empty());
    }

    #[test]
    fn a_line_that_leaves_and_returns_has_two_parts() {
        let view = View::new(&Frame { west: 0.0, south: 0.0, east: 100.0, north: 100.0 });
        let track = view.placed(&[[10.0, 10.0], [10.0, 150.0], [90.0, 150.0], [90.0, 50.0], [80.0, 50.0]]);
        let parts = line(&view, &track);
        assert_eq!(parts.iter().map(Vec::len).collect::<Vec<_>>(), [2, 3]);
        assert!(parts.iter().flatten().all(|&p| view.holds(p, -1e-9)));
        assert!(line(&view, &view.placed(&[[-5.0, 0.0], [-5.0, 50.0]])).is_empty());
    }
}
