use std::ops::{Div, Mul, Sub};

use faer::linalg::solvers::{DenseSolveCore, Solve as _};
use faer::{MatRef, Side};

use crate::vectorized;

/// A determinant by sign and logarithm of its modulus.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LogDet {
    /// log|det|.
    pub log_abs: f64,
    /// 1 or −1.
    pub sign: f64,
}

/// Rows from which on faer is faster.
const LARGE: usize = 48;

/// Solves A X = B by Gaussian elimination with partial pivoting. `a`: n × n, destroyed. `b`: n × columns, replaced by
/// X. `None` where a pivot is zero or not finite.
pub fn solve(n: usize, a: &mut [f64], b: &mut [f64]) -> Option<()> {
    if n >= LARGE {
        return solve_large(n, a, b);
    }
    vectorized!(solved(n, a, b)).map(|_| ())
}

/// Replaces B by X and returns the sign of the determinant; the pivots are then on the diagonal of `a`. For all instruction sets
/// the same sums in the same order.
#[inline(always)]
fn solved(n: usize, a: &mut [f64], b: &mut [f64]) -> Option<f64> {
    let columns = b.len() / n.max(1);
    let sign = eliminate(n, a, columns, b)?;
    for row in (0..n).rev() {
        let (head, tail) = b.split_at_mut((row + 1) * columns);
        let target = &mut head[row * columns..];
        for (below, coefficient) in tail.chunks_exact(columns).zip(&a[row * n + row + 1..(row + 1) * n]) {
            for (t, x) in target.iter_mut().zip(below) {
                *t -= coefficient * x;
            }
        }
        let pivot = a[row * n + row];
        target.iter_mut().for_each(|t| *t /= pivot);
    }
    Some(sign)
}

/// The inverse of A (n × n, destroyed) into `out` (n × n).
pub fn inverse(n: usize, a: &mut [f64], out: &mut [f64]) -> Option<()> {
    if n >= LARGE {
        return inverse_large(n, a, out);
    }
    signed_inverse(n, a, out).map(|_| ())
}

/// The inverse of a symmetric positive definite A (n × n), in correlations: rows and columns of very different size do no harm.
/// `None` where it is singular.
pub fn scaled_inverse(n: usize, a: &[f64]) -> Option<Vec<f64>> {
    let scale: Vec<f64> = (0..n).map(|i| a[i * n + i].sqrt()).collect();
    let mut correlations: Vec<f64> = (0..n * n).map(|k| a[k] / (scale[k / n] * scale[k % n])).collect();
    let mut out = vec![0.0; n * n];
    inverse(n, &mut correlations, &mut out)?;
    (0..n * n).for_each(|k| out[k] /= scale[k / n] * scale[k % n]);
    out.iter().all(|entry| entry.is_finite()).then_some(out)
}

/// The inverse of A (n × n, destroyed) into `out` (n × n), with the determinant.
pub fn inverse_and_log_det(n: usize, a: &mut [f64], out: &mut [f64]) -> Option<LogDet> {
    signed_inverse(n, a, out).map(|sign| of_pivots(n, a, sign))
}

fn signed_inverse(n: usize, a: &mut [f64], out: &mut [f64]) -> Option<f64> {
    out.fill(0.0);
    out.iter_mut().step_by(n + 1).for_each(|d| *d = 1.0);
    vectorized!(solved(n, a, out))
}

/// The inverse of A (n × n, destroyed) into `out` (n × n) by Gauss–Jordan elimination without row exchanges;
/// the pivots are then on the diagonal of `a`. For lanes of matrices, which cannot exchange rows
/// individually: the caller checks the pivots, and passes matrices with small ones to [`inverse`].
#[inline(always)]
pub fn inverse_in_order<T>(n: usize, a: &mut [T], out: &mut [T])
where
    T: Copy + From<f64> + Sub<Output = T> + Mul<Output = T> + Div<Output = T>,
{
    for (k, entry) in out[..n * n].iter_mut().enumerate() {
        *entry = T::from(if k % (n + 1) == 0 { 1.0 } else { 0.0 });
    }
    for k in 0..n {
        let share = T::from(1.0) / a[k * n + k];
        for j in 0..n {
            if j > k {
                a[k * n + j] = a[k * n + j] * share;
            }
            out[k * n + j] = out[k * n + j] * share;
        }
        for row in (0..n).filter(|row| *row != k) {
            let factor = a[row * n + k];
            for j in 0..n {
                if j > k {
                    a[row * n + j] = a[row * n + j] - factor * a[k * n + j];
                }
                out[row * n + j] = out[row * n + j] - factor * out[k * n + j];
            }
        }
    }
}

/// Condition number in the 1-norm of A (n × n); infinite where it is singular.
pub fn condition(n: usize, a: &[f64]) -> f64 {
    let (mut destroyed, mut inverted) = (a.to_vec(), vec![0.0; n * n]);
    match inverse(n, &mut destroyed, &mut inverted) {
        Some(_) => one_norm(n, a) * one_norm(n, &inverted),
        None => f64::INFINITY,
    }
}

/// Largest column sum of moduli.
pub fn one_norm(n: usize, a: &[f64]) -> f64 {
    (0..n).map(|j| (0..n).map(|i| a[i * n + j].abs()).sum()).fold(0.0, f64::max)
}

/// The determinant of A (n × n, destroyed).
pub fn log_det(n: usize, a: &mut [f64]) -> Option<LogDet> {
    eliminate(n, a, 0, &mut []).map(|sign| of_pivots(n, a, sign))
}

/// The determinant of a matrix that was reduced to `a`.
fn of_pivots(n: usize, a: &[f64], sign: f64) -> LogDet {
    LogDet { log_abs: a.iter().step_by(n + 1).map(|pivot| libm::log(pivot.abs())).sum(), sign }
}

/// Reduces A to upper triangular form, doing the same to the rows of B, and returns the sign of its determinant.
#[inline(always)]
fn eliminate(n: usize, a: &mut [f64], columns: usize, b: &mut [f64]) -> Option<f64> {
    let mut sign = 1.0;
    for k in 0..n {
        let pivot_row = (k..n).max_by(|i, j| a[i * n + k].abs().total_cmp(&a[j * n + k].abs()))?;
        let pivot = a[pivot_row * n + k];
        if pivot == 0.0 || !pivot.is_finite() {
            return None;
        }
        if pivot_row != k {
            swap_rows(a, n, k, pivot_row);
            swap_rows(b, columns, k, pivot_row);
            sign = -sign;
        }
        sign *= pivot.signum();
        for row in k + 1..n {
            let factor = a[row * n + k] / pivot;
            if factor != 0.0 {
                subtract_row(&mut a[..], n, k, row, k + 1, factor);
                subtract_row(b, columns, k, row, 0, factor);
            }
        }
    }
    Some(sign)
}

/// Row `row` minus `factor` times row `k` (above it), from column `from` on.
#[inline(always)]
fn subtract_row(a: &mut [f64], width: usize, k: usize, row: usize, from: usize, factor: f64) {
    let (above, below) = a.split_at_mut(row * width);
    for (x, p) in below[from..width].iter_mut().zip(&above[k * width + from..(k + 1) * width]) {
        *x -= factor * p;
    }
}

#[inline(always)]
fn swap_rows(a: &mut [f64], width: usize, upper: usize, lower: usize) {
    let (above, below) = a.split_at_mut(lower * width);
    above[upper * width..(upper + 1) * width].swap_with_slice(&mut below[..width]);
}

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
    let svd = MatRef::from_row_major_slice(a, n, n).svd().ok()?;
    let (values, vectors) = (svd.S().column_vector(), svd.V());
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
    let eigen = MatRef::from_row_major_slice(a, n, n).self_adjoint_eigen(Side::Lower).ok()?;
    let (values, vectors) = (eigen.S().column_vector(), eigen.U());
    Some(((0..n).map(|i| values[i]).collect(), (0..n * n).map(|k| vectors[(k / n, k % n)]).collect()))
}

/// [`crate::solve`] for large systems, which keeps `a`.
fn solve_large(n: usize, a: &[f64], b: &mut [f64]) -> Option<()> {
    let columns = b.len() / n;
    let solution = MatRef::from_row_major_slice(a, n, n)
        .partial_piv_lu()
        .solve(MatRef::from_row_major_slice(b, n, columns));
    b.iter_mut().enumerate().for_each(|(k, x)| *x = solution[(k / columns, k % columns)]);
    b.iter().all(|x| x.is_finite()).then_some(())
}

/// [`crate::inverse`] for large matrices, which keeps `a`.
fn inverse_large(n: usize, a: &[f64], out: &mut [f64]) -> Option<()> {
    let inverted = MatRef::from_row_major_slice(a, n, n).partial_piv_lu().inverse();
    out.iter_mut().enumerate().for_each(|(k, x)| *x = inverted[(k / n, k % n)]);
    out.iter().all(|x| x.is_finite()).then_some(())
}
