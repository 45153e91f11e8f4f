//! Which cells segments and polygons cover. Coordinates are in units of cells; a span is (row, first, last
//! column).

/// Number of columns and rows.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Size {
    pub nx: usize,
    pub ny: usize,
}

impl Size {
    /// The whole numbers from floor(low) to floor(high) among 0..count.
    fn clamp(low: f64, high: f64, count: usize) -> Option<(usize, usize)> {
        if high < 0.0 || low >= count as f64 {
            return None;
        }
        // The conversion to an integer rounds down.
        let (first, last) = (low.max(0.0) as usize, (high as usize).min(count - 1));
        (first <= last).then_some((first, last))
    }
}

/// All cells within `slack` of a segment: those that it passes or touches, and no cell farther than `slack`
/// from it.
pub(crate) fn along(
    a: [f64; 2],
    b: [f64; 2],
    slack: f64,
    size: Size,
    mut span: impl FnMut(usize, usize, usize),
) {
    let (low, high) = (a[1].min(b[1]) - slack, a[1].max(b[1]) + slack);
    let Some((first_row, last_row)) = Size::clamp(low, high, size.ny) else { return };
    for row in first_row..=last_row {
        let [x0, x1] = columns(a, b, row as f64 - slack, row as f64 + 1.0 + slack);
        if let Some((first, last)) = Size::clamp(x0 - slack, x1 + slack, size.nx) {
            span(row, first, last);
        }
    }
}

/// Range of x of a segment between two heights, one of which it reaches.
fn columns(a: [f64; 2], b: [f64; 2], low: f64, high: f64) -> [f64; 2] {
    let at = |y: f64| {
        let t = (y - a[1]) / (b[1] - a[1]);
        a[0] + t.clamp(0.0, 1.0) * (b[0] - a[0])
    };
    let level = (b[1] - a[1]).abs() < 1e-12;
    let (x0, x1) = if level { (a[0], b[0]) } else { (at(low), at(high)) };
    [x0.min(x1), x0.max(x1)]
}

/// The edges of rings that are not closed.
pub(crate) fn each_edge(rings: &[Vec<[f64; 2]>], mut edge: impl FnMut([f64; 2], [f64; 2])) {
    for ring in rings {
        let mut p = ring.last().copied().unwrap_or_default();
        for q in ring {
            edge(p, *q);
            p = *q;
        }
    }
}

/// All cells whose centre is inside the rings (not closed) by the even-odd rule.
pub(crate) fn centres(rings: &[Vec<[f64; 2]>], size: Size, mut span: impl FnMut(usize, usize, usize)) {
    let mut crossings: Vec<(usize, f64)> = Vec::new();
    each_edge(rings, |p, q| cross_rows(p, q, size, &mut crossings));
    crossings.sort_unstable_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)));
    // Every row is crossed an even number of times, so pairs never span rows.
    for pair in crossings.as_chunks::<2>().0 {
        let [(row, x0), (_, x1)] = *pair;
        if let Some((first, last)) = Size::clamp((x0 - 0.5).ceil(), (x1 - 0.5).ceil() - 1.0, size.nx) {
            span(row, first, last);
        }
    }
}

/// Where an edge crosses the centre lines of rows; the upper end of an edge does not belong to it.
fn cross_rows(p: [f64; 2], q: [f64; 2], size: Size, crossings: &mut Vec<(usize, f64)>) {
    let (low, high) = if p[1] <= q[1] { (p, q) } else { (q, p) };
    let first = (low[1] - 0.5).ceil();
    let last = (high[1] - 0.5).ceil() - 1.0;
    let Some((first, last)) = Size::clamp(first, last, size.ny) else { return };
    for row in first..=last {
        let t = (row as f64 + 0.5 - low[1]) / (high[1] - low[1]);
        crossings.push((row, low[0] + t * (high[0] - low[0])));
    }
}
