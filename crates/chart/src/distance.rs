//! Exact Euclidean distance transform (Felzenszwalb and Huttenlocher 2012), of gaps between cells.

/// Squared gap, in units of cells, from every cell to the nearest set cell: the least distance of any of
/// their points, max(|Δcol| − 1, 0)² + max(|Δrow| − 1, 0)². Infinite where no cell is set. Row by row, as
/// `set`.
///
/// The gap between squares is the distance between centres after the set cells have grown by their eight
/// neighbours, so the transform of centres stays exact.
pub(crate) fn squared_gaps(set: &[bool], nx: usize) -> Vec<f64> {
    let mut squared = vertical_gaps(set, nx);
    let mut envelope = Envelope::with_capacity(nx);
    let mut grown = vec![0.0; nx];
    for row in squared.chunks_mut(nx) {
        for (i, g) in grown.iter_mut().enumerate() {
            let near = i.saturating_sub(1)..(i + 2).min(nx);
            *g = row[near].iter().copied().fold(f64::INFINITY, f64::min);
        }
        envelope.build(&grown);
        envelope.fill(row);
    }
    squared
}

/// Squared gap to the nearest set cell of the same column.
fn vertical_gaps(set: &[bool], nx: usize) -> Vec<f64> {
    let mut rows = vec![f64::INFINITY; set.len()];
    let ny = set.len() / nx.max(1);
    let mut since = vec![f64::INFINITY; nx];
    let mut sweep = |row: usize, rows: &mut Vec<f64>| {
        for (i, s) in since.iter_mut().enumerate() {
            let k = row * nx + i;
            *s = if set[k] { 0.0 } else { *s + 1.0 };
            rows[k] = rows[k].min(*s);
        }
    };
    (0..ny).for_each(|row| sweep(row, &mut rows));
    // What the first sweep leaves over is a distance of the last row from below: too long for any row
    // above, so harmless.
    (0..ny).rev().for_each(|row| sweep(row, &mut rows));
    for r in &mut rows {
        *r = (*r - 1.0).max(0.0).powi(2);
    }
    rows
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
