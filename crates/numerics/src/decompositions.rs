//! Decompositions by faer.

use faer::linalg::solvers::{DenseSolveCore, Solve};
use faer::{MatRef, Side};

/// The weakest direction of a matrix.
#[derive(Clone, Debug, PartialEq)]
pub struct Weakest {
    /// Smallest over largest singular value: the reciprocal condition number.
    pub ratio: f64,
    /// The right singular vector of the smallest singular value; its largest entry is positive.
    pub direction: Vec<f64>,
}

impl Weakest {
    /// The index, among the first `n`, of the dominant entry of the direction.
    pub fn dominant(&self, n: usize) -> usize {
        largest(&self.direction[..n])
    }
}

/// The index of the entry of largest modulus.
fn largest(of: &[f64]) -> usize {
    (0..of.len()).max_by(|i, j| of[*i].abs().total_cmp(&of[*j].abs())).unwrap_or(0)
}

/// The weakest direction of A (n × n). `None` where an entry is not finite or A is zero.
pub fn weakest(n: usize, a: &[f64]) -> Option<Weakest> {
    if !a.iter().all(|x| x.is_finite()) || a.iter().all(|x| *x == 0.0) {
        return None;
    }
    let found = MatRef::from_row_major_slice(a, n, n).svd().ok()?;
    let (values, vectors) = (found.S().column_vector(), found.V());
    let mut direction: Vec<f64> = (0..n).map(|i| vectors[(i, n - 1)]).collect();
    if direction[largest(&direction)] < 0.0 {
        direction.iter_mut().for_each(|x| *x = -*x);
    }
    Some(Weakest { ratio: values[n - 1] / values[0], direction })
}

/// Eigenvalues of a symmetric matrix (n × n), ascending, and its eigenvectors, one per column. `None` where an entry is not
/// finite.
pub fn symmetric(n: usize, a: &[f64]) -> Option<(Vec<f64>, Vec<f64>)> {
    if !a.iter().all(|x| x.is_finite()) {
        return None;
    }
    let found = MatRef::from_row_major_slice(a, n, n).self_adjoint_eigen(Side::Lower).ok()?;
    let (values, vectors) = (found.S().column_vector(), found.U());
    Some(((0..n).map(|i| values[i]).collect(), (0..n * n).map(|k| vectors[(k / n, k % n)]).collect()))
}

/// [`crate::solve`] for large systems, which keeps `a`.
pub(crate) fn solve(n: usize, a: &[f64], b: &mut [f64]) -> Option<()> {
    let columns = b.len() / n;
    let found = MatRef::from_row_major_slice(a, n, n)
        .partial_piv_lu()
        .solve(MatRef::from_row_major_slice(b, n, columns));
    b.iter_mut().enumerate().for_each(|(k, x)| *x = found[(k / columns, k % columns)]);
    b.iter().all(|x| x.is_finite()).then_some(())
}

/// [`crate::inverse`] for large matrices, which keeps `a`.
pub(crate) fn inverse(n: usize, a: &[f64], out: &mut [f64]) -> Option<()> {
    let found = MatRef::from_row_major_slice(a, n, n).partial_piv_lu().inverse();
    out.iter_mut().enumerate().for_each(|(k, x)| *x = found[(k / n, k % n)]);
    out.iter().all(|x| x.is_finite()).then_some(())
}
