//! Products of small square blocks, n × n, row-major.

use std::ops::{AddAssign, Mul};

use crate::vectorized;

/// A B.
pub fn product(n: usize, a: &[f64], b: &[f64]) -> Vec<f64> {
    let mut out = vec![0.0; n * n];
    if n > 0 {
        vectorized!(add_product(n, a, b, &mut out));
    }
    out
}

/// Columns of a product that are summed in parallel.
const COLUMNS: usize = 8;

/// Adds A B to zeros: for all instruction sets the same sums in the same order.
#[inline(always)]
fn add_product(n: usize, a: &[f64], b: &[f64], out: &mut [f64]) {
    for (row, left) in out.chunks_exact_mut(n).zip(a.chunks_exact(n)) {
        if n < COLUMNS {
            for (factor, right) in left.iter().zip(b.chunks_exact(n)) {
                row.iter_mut().zip(right).for_each(|(o, r)| *o += factor * r);
            }
            continue;
        }
        // The last block has the same width; it repeats some columns.
        for first in (0..n.next_multiple_of(COLUMNS)).step_by(COLUMNS).map(|first| first.min(n - COLUMNS)) {
            let mut sums = [0.0; COLUMNS];
            for (factor, right) in left.iter().zip(b.chunks_exact(n)) {
                if let Some(right) = right[first..].first_chunk::<COLUMNS>() {
                    for (sum, right) in sums.iter_mut().zip(right) {
                        *sum += factor * right;
                    }
                }
            }
            row[first..first + COLUMNS].copy_from_slice(&sums);
        }
    }
}

/// Aᵀ.
pub fn transposed(n: usize, a: &[f64]) -> Vec<f64> {
    (0..n * n).map(|k| a[(k % n) * n + k / n]).collect()
}

/// A B Aᵀ.
pub fn congruence(n: usize, a: &[f64], b: &[f64]) -> Vec<f64> {
    product(n, &product(n, a, b), &transposed(n, a))
}

/// Adds x yᵀ to A.
pub fn add_outer(a: &mut [f64], x: &[f64], y: &[f64]) {
    for (row, x) in a.chunks_exact_mut(y.len().max(1)).zip(x) {
        row.iter_mut().zip(y).for_each(|(a, y)| *a += x * y);
    }
}

/// Entries from which on checking the processor pays off.
const MANY: usize = 64;

/// Σ_ij a_ij b_ij, over the entries that both have: eight sums in parallel, so that none waits for the previous one.
pub fn dot(a: &[f64], b: &[f64]) -> f64 {
    let both = a.len().min(b.len());
    let (a, b) = (&a[..both], &b[..both]);
    if both < MANY { dot_of_equals(a, b) } else { vectorized!(dot_of_equals(a, b)) }
}

/// [`dot`] of as many entries.
#[inline(always)]
fn dot_of_equals(a: &[f64], b: &[f64]) -> f64 {
    let ((a, a_rest), (b, b_rest)) = (a.as_chunks::<8>(), b.as_chunks::<8>());
    let mut sums = [0.0; 8];
    for (a, b) in a.iter().zip(b) {
        for i in 0..8 {
            sums[i] += a[i] * b[i];
        }
    }
    let rest: f64 = a_rest.iter().zip(b_rest).map(|(a, b)| a * b).sum();
    let [s0, s1, s2, s3, s4, s5, s6, s7] = sums;
    ((s0 + s4) + (s2 + s6)) + ((s1 + s5) + (s3 + s7)) + rest
}

/// Adds c_k x_k to `out` for every row x_k of `rows`, in order; each row has as many entries as `out`, and a coefficient c_k.
pub fn add_rows(out: &mut [f64], rows: &[f64], coefficients: &[f64]) {
    if out.is_empty() {
        return;
    }
    vectorized!(for (row, c) in rows.chunks_exact(out.len()).zip(coefficients) {
        if *c != 0.0 {
            for (o, x) in out.iter_mut().zip(row) {
                *o += c * x;
            }
        }
    });
}

/// A x.
pub fn times(a: &[f64], x: &[f64]) -> Vec<f64> {
    a.chunks_exact(x.len().max(1)).map(|row| dot(row, x)).collect()
}

/// xᵀ A x, for numbers or lanes.
#[inline(always)]
pub fn quadratic<T: Copy + From<f64> + Mul<Output = T> + AddAssign>(x: &[T], a: &[T]) -> T {
    let mut sum = T::from(0.0);
    for (row, left) in a.chunks_exact(x.len().max(1)).zip(x) {
        for (entry, right) in row.iter().zip(x) {
            sum += *left * *entry * *right;
        }
    }
    sum
}

/// sᵀV⁺s and the rank of V, a positive semidefinite matrix n × n, with `s` in its range. V is what is left of a matrix with
/// the diagonal `whole`: a pivot counts if it is more than the share `least` of that.
pub fn quadratic_of_inverse(mut v: Vec<f64>, mut s: Vec<f64>, whole: &[f64], least: f64) -> (f64, usize) {
    let p = s.len();
    let (mut statistic, mut rank) = (0.0, 0);
    loop {
        let share = |i: &usize| if whole[*i] > 0.0 { v[i * p + i] / whole[*i] } else { 0.0 };
        let Some(best) = (0..p).max_by(|a, b| share(a).total_cmp(&share(b))) else { break };
        if share(&best) <= least {
            break;
        }
        let pivot = v[best * p + best];
        let row: Vec<f64> = v[best * p..(best + 1) * p].to_vec();
        let score = s[best];
        statistic += score * score / pivot;
        rank += 1;
        for i in 0..p {
            s[i] -= row[i] * score / pivot;
            for j in 0..p {
                v[i * p + j] -= row[i] * row[j] / pivot;
            }
        }
        v[best * p + best] = 0.0;
    }
    (statistic, rank)
}

/// The columns that depend linearly on those before them, from their n × n sums of products `a`, by Cholesky's method: those
/// before them leave at most the share `least` of their squares.
pub fn dependent_columns(n: usize, a: &[f64], least: f64) -> Vec<usize> {
    let (mut rows, mut dependent): (Vec<(usize, Vec<f64>)>, Vec<usize>) = (Vec::new(), Vec::new());
    for i in 0..n {
        let mut row: Vec<f64> = Vec::with_capacity(rows.len() + 1);
        for (j, before) in &rows {
            let rest = a[i * n + j] - dot(&row, &before[..row.len()]);
            row.push(rest / before[row.len()]);
        }
        let rest = a[i * n + i] - dot(&row, &row);
        if rest <= least * a[i * n + i] {
            dependent.push(i);
        } else {
            row.push(rest.sqrt());
            rows.push((i, row));
        }
    }
    dependent
}
