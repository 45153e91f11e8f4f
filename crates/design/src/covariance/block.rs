use std::ops::Range;

use numerics::dot;

/// The rows of one block: `range` in the matrices, `rows` over all blocks; the root V of its weights, k × n.
pub(super) struct Block<'a> {
    pub n: usize,
    pub range: Range<usize>,
    pub rows: Range<usize>,
    pub root: &'a [f64],
}

impl Block<'_> {
    /// Rows of the root.
    pub fn kept(&self) -> usize {
        self.root.len() / self.n.max(1)
    }

    /// V C Vᵀ, k × k.
    pub fn weighted(&self, matrix: &[f64]) -> Vec<f64> {
        let (n, k) = (self.n, self.kept());
        let mut half = vec![0.0; k * n];
        multiply(k, n, self.root, matrix, &mut half);
        let rows = |i: usize| &half[i * n..(i + 1) * n];
        let root = |j: usize| &self.root[j * n..(j + 1) * n];
        (0..k * k).map(|e| dot(rows(e / k), root(e % k))).collect()
    }

    /// Vᵀ K V, n × n.
    pub fn unweighted(&self, kept: &[f64]) -> Vec<f64> {
        let (n, k) = (self.n, self.kept());
        let mut half = vec![0.0; k * n];
        multiply(k, k, kept, self.root, &mut half);
        let mut out = vec![0.0; n * n];
        for (row, root) in half.chunks_exact(n).zip(self.root.chunks_exact(n)) {
            for (line, r) in out.chunks_exact_mut(n).zip(root).filter(|(_, r)| **r != 0.0) {
                line.iter_mut().zip(row).for_each(|(o, x)| *o += r * x);
            }
        }
        out
    }
}

/// A B of a rows × m and an m × n matrix; zeros in A are skipped.
fn multiply(rows: usize, m: usize, a: &[f64], b: &[f64], out: &mut [f64]) {
    let n = out.len() / rows.max(1);
    for (line, left) in out.chunks_exact_mut(n.max(1)).zip(a.chunks_exact(m.max(1))) {
        for (factor, right) in left.iter().zip(b.chunks_exact(n.max(1))).filter(|(f, _)| **f != 0.0) {
            line.iter_mut().zip(right).for_each(|(o, r)| *o += factor * r);
        }
    }
}
