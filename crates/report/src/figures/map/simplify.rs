use crate::figures::svg::Point;

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
