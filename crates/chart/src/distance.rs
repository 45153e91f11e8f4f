//! Exact Euclidean distance transform (Felzenszwalb and Huttenlocher 2012), of gaps between cells.

/// Squared gap, in units of cells, from every cell to the nearest set cell: the least distance of any of
/// their points, max(|Δcol| − 1, 0)² + max(|Δrow| − 1, 0)². Infinite where no cell is set. `each` is called
/// with every row of `nx` columns in turn. `None` once `keep_going`, which is checked at every row, returns false.
///
/// The gap between squares is the distance between centres after the set cells have grown by their eight
/// neighbours, so the transform of centres stays exact.
pub(crate) fn squared_gaps(
    set: impl Fn(usize) -> bool,
    [nx, ny]: [usize; 2],
    keep_going: &dyn Fn() -> bool,
    mut each: impl FnMut(usize, &[f64]),
) -> Option<()> {
    let vertical = vertical_gaps(set, [nx, ny], keep_going)?;
    let mut envelope = Envelope::with_capacity(nx);
    let (mut grown, mut squared) = (vec![0.0; nx], vec![0.0; nx]);
    for (row, rows) in vertical.chunks(nx.max(1)).enumerate() {
        for (i, g) in grown.iter_mut().enumerate() {
            let near = i.saturating_sub(1)..(i + 2).min(nx);
            *g = between(rows[near].iter().copied().min().unwrap_or(NONE));
        }
        envelope.build(&grown);
        envelope.fill(&mut squared);
        each(row, &squared);
        keep_going().then_some(())?;
    }
    Some(())
}

/// No set cell in a column.
const NONE: u32 = u32::MAX;

/// Squared gap of cells whose rows differ by `rows`.
fn between(rows: u32) -> f64 {
    if rows == NONE { f64::INFINITY } else { f64::from(rows.saturating_sub(1)).powi(2) }
}

/// Rows to the nearest set cell of the same column.
fn vertical_gaps(
    set: impl Fn(usize) -> bool,
    [nx, ny]: [usize; 2],
    keep_going: &dyn Fn() -> bool,
) -> Option<Vec<u32>> {
    let mut rows = vec![NONE; nx * ny];
    let mut since = vec![NONE; nx];
    let mut sweep = |row: usize| {
        for (i, s) in since.iter_mut().enumerate() {
            let k = row * nx + i;
            *s = if set(k) { 0 } else { s.saturating_add(1) };
            rows[k] = rows[k].min(*s);
        }
        keep_going().then_some(())
    };
    (0..ny).try_for_each(&mut sweep)?;
    // After the first sweep a distance in the last row counts from below: it is too long for any row above,
    // so harmless.
    (0..ny).rev().try_for_each(sweep)?;
    Some(rows)
}

/// Lower envelope of the parabolas (x − i)² + f(i).
struct Envelope {
    /// Where each parabola of the envelope begins, its vertex and height.
    parts: Vec<(f64, f64, f64)>,
}

impl Envelope {
    fn with_capacity(n: usize) -> Self {
        Self { parts: Vec::with_capacity(n) }
    }

    fn build(&mut self, f: &[f64]) {
        self.parts.clear();
        for (i, height) in f.iter().copied().enumerate().filter(|(_, h)| h.is_finite()) {
            let vertex = i as f64;
            let meets = |&(_, v, h): &(f64, f64, f64)| {
                ((height + vertex * vertex) - (h + v * v)) / (2.0 * (vertex - v))
            };
            while self.parts.last().is_some_and(|part| meets(part) <= part.0) {
                self.parts.pop();
            }
            let begin = self.parts.last().map_or(f64::NEG_INFINITY, meets);
            self.parts.push((begin, vertex, height));
        }
    }

    fn fill(&self, row: &mut [f64]) {
        let mut k = 0;
        for (i, value) in row.iter_mut().enumerate() {
            let x = i as f64;
            while self.parts.get(k + 1).is_some_and(|next| next.0 <= x) {
                k += 1;
            }
            *value = self.parts.get(k).map_or(f64::INFINITY, |(_, v, h)| (x - v).powi(2) + h);
        }
    }
}
