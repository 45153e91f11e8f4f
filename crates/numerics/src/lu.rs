use std::ops::{Div, Mul, Sub};

use pulp::{Simd, WithSimd};

use crate::decompositions;

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
        return decompositions::solve(n, a, b);
    }
    crate::dispatch(Solve { n, a, b }).map(|_| ())
}

/// The arguments, for the instruction sets that pulp selects from: the same sums in the same order, so that
/// all give the same bits.
struct Solve<'a> {
    n: usize,
    a: &'a mut [f64],
    b: &'a mut [f64],
}

impl WithSimd for Solve<'_> {
    type Output = Option<f64>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> Option<f64> {
        let Self { n, a, b } = self;
        solved(n, a, b)
    }
}

/// Replaces B by X and returns the sign of the determinant; the pivots are then on the diagonal of `a`.
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
        return decompositions::inverse(n, a, out);
    }
    signed_inverse(n, a, out).map(|_| ())
}

/// The inverse of a symmetric positive definite A (n × n), in correlations: rows and columns of very different size do no harm.
/// `None` where it is singular.
pub fn scaled_inverse(n: usize, a: &[f64]) -> Option<Vec<f64>> {
    let scale: Vec<f64> = (0..n).map(|i| a[i * n + i].sqrt()).collect();
    let mut own: Vec<f64> = (0..n * n).map(|k| a[k] / (scale[k / n] * scale[k % n])).collect();
    let mut out = vec![0.0; n * n];
    inverse(n, &mut own, &mut out)?;
    (0..n * n).for_each(|k| out[k] /= scale[k / n] * scale[k % n]);
    out.iter().all(|own| own.is_finite()).then_some(out)
}

/// The inverse of A (n × n, destroyed) into `out` (n × n), with the determinant.
pub fn inverse_and_log_det(n: usize, a: &mut [f64], out: &mut [f64]) -> Option<LogDet> {
    signed_inverse(n, a, out).map(|sign| of_pivots(n, a, sign))
}

fn signed_inverse(n: usize, a: &mut [f64], out: &mut [f64]) -> Option<f64> {
    out.fill(0.0);
    out.iter_mut().step_by(n + 1).for_each(|d| *d = 1.0);
    crate::dispatch(Solve { n, a, b: out })
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

/// Reduces A to upper triangular form, doing the same to the rows of B, and returns the sign of its
/// determinant.
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
