//! Normal equations of θ, from which the starts of windows are eliminated.

use crate::fitting::sums::Sums;

/// What a window says of θ once its start is chosen best, and how the start then follows θ.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Reduced {
    /// Square, of θ.
    pub products: Vec<f64>,
    pub gradient: Vec<f64>,
    /// How the start changes with each of θ: 3 rows.
    pub follows: Vec<f64>,
    /// How it changes where θ stays.
    pub own: [f64; 3],
}

/// Share that is added to the diagonal of a start that is singular to all digits.
const SINGULAR: f64 = 1e-9;

/// The sums of `window` over θ of length `n` alone; `damping` is a share that is added to the diagonal of its start.
/// `None` where the start is not determined.
pub(crate) fn reduced(window: &Sums, n: usize, damping: f64) -> Option<Reduced> {
    let all = n + window.starts(n);
    let at = |i: usize, j: usize| window.products[i * all + j];
    let gradient: Vec<f64> = (0..all).map(|i| window.pieces.iter().map(|own| own[i]).sum()).collect();
    let mut products: Vec<f64> = (0..n * n).map(|k| at(k / n, k % n)).collect();
    if all == n {
        return Some(Reduced { products, gradient, follows: vec![0.0; 3 * n], own: [0.0; 3] });
    }
    // Columns: θ, then the gradient.
    let mut sides: Vec<f64> = Vec::with_capacity(3 * (n + 1));
    for d in 0..3 {
        sides.extend((0..n).map(|i| at(n + d, i)));
        sides.push(gradient[n + d]);
    }
    let follows = window.solved_by_start(n, damping, &sides)?;
    let row = |d: usize| &follows[d * (n + 1)..][..n + 1];
    let mut left: Vec<f64> = gradient[..n].to_vec();
    for i in 0..n {
        for d in 0..3 {
            let across = at(i, n + d);
            left[i] -= across * row(d)[n];
            (0..n).for_each(|j| products[i * n + j] -= across * row(d)[j]);
        }
    }
    let own = [0, 1, 2].map(|d| -row(d)[n]);
    let follows = (0..3).flat_map(|d| row(d)[..n].iter().map(|own| -own)).collect();
    Some(Reduced { products, gradient: left, follows, own })
}

impl Sums {
    /// Unknowns of its start, besides `n` of θ.
    pub fn starts(&self, n: usize) -> usize {
        self.pieces.first().map_or(0, |own| own.len() - n)
    }

    /// What solves the products of the start for the right-hand `sides`, a row for each of its unknowns; `damping` is a share
    /// that is added to the diagonal. `None` where the start is not determined.
    pub fn solved_by_start(&self, n: usize, damping: f64, sides: &[f64]) -> Option<Vec<f64>> {
        let starts = self.starts(n);
        let all = n + starts;
        let solved = |damping: f64| {
            let at = |k: usize| self.products[(n + k / starts) * all + n + k % starts];
            let mut square: Vec<f64> = (0..starts * starts).map(at).collect();
            (0..starts).for_each(|d| square[(starts + 1) * d] *= 1.0 + damping);
            let mut own = sides.to_vec();
            numerics::solve(starts, &mut square, &mut own).map(|()| own)
        };
        // A window that is unstable, such as one astern, has a start of which one sum alone is told, to all digits.
        solved(damping).or_else(|| solved(damping.max(SINGULAR)))
    }

    /// Jᵀe of each piece, of θ alone: what the start makes of it is followed by `reduced`.
    pub fn scores(&self, reduced: &Reduced, n: usize) -> Vec<Vec<f64>> {
        let starts = self.starts(n);
        let score = |piece: &Vec<f64>| {
            (0..n)
                .map(|i| {
                    piece[i] + (0..starts).map(|d| reduced.follows[d * n + i] * piece[n + d]).sum::<f64>()
                })
                .collect()
        };
        self.pieces.iter().map(score).collect()
    }
}
