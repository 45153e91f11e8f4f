use crate::figures::svg::Point;

/// At most about `most` points of a curve that keep its peaks: of each section the first, lowest and highest point.
/// Points that are not finite are dropped.
pub(crate) fn thinned(points: impl IntoIterator<Item = Point>, most: usize) -> Vec<Point> {
    let finite = points.into_iter().filter(|(x, y)| x.is_finite() && y.is_finite());
    let points: Vec<Point> = finite.collect();
    if points.len() <= most {
        return points;
    }
    let stretch = (3 * points.len()).div_ceil(most.max(3));
    let mut kept: Vec<Point> = points.chunks(stretch).flat_map(landmarks).collect();
    kept.extend(points.last());
    kept
}

fn landmarks(stretch: &[Point]) -> Vec<Point> {
    let height = |i: &usize, j: &usize| stretch[*i].1.total_cmp(&stretch[*j].1);
    let lowest = (0..stretch.len()).min_by(height).unwrap_or(0);
    let highest = (0..stretch.len()).max_by(height).unwrap_or(0);
    let mut kept = vec![0, lowest, highest];
    kept.sort_unstable();
    kept.dedup();
    kept.into_iter().map(|i| stretch[i]).collect()
}
