use serde::{Deserialize, Serialize};

use crate::{Candidates, Error};

/// Whether the criterion is concave on the simplex: every matrix is symmetric positive semidefinite, possibly after
/// multiplying its rows by positive numbers that are the same for all candidates (which changes log|det| by a
/// constant). Then a small Kiefer–Wolfowitz gap bounds the distance to the global optimum.
pub fn is_concave(candidates: &Candidates) -> bool {
    candidates.blocks().all(|(n, range)| {
        let matrices = || (0..candidates.len()).map(|q| &candidates.candidate(q)[range.clone()]);
        row_scaling(n, matrices()).is_some_and(|rows| matrices().all(|m| is_semidefinite(n, m, &rows)))
    })
}

/// Positive factors d with d_i m_ij = d_j m_ji for the sum of moduli, found along the strongest couplings from row 0.
pub(crate) fn row_scaling<'a>(n: usize, matrices: impl Iterator<Item = &'a [f64]>) -> Option<Vec<f64>> {
    let mut ratios = vec![(0.0, 0.0); n * n];
    for m in matrices {
        for i in 0..n {
            for j in 0..n {
                ratios[i * n + j].0 += m[i * n + j] * m[i * n + j];
                ratios[i * n + j].1 += m[i * n + j] * m[j * n + i];
            }
        }
    }
    let mut scaling = vec![1.0; n];
    let mut known = vec![false; n];
    for start in 0..n {
        if known[start] {
            continue;
        }
        known[start] = true;
        let mut queue = vec![start];
        while let Some(i) = queue.pop() {
            for j in 0..n {
                let (square, cross) = ratios[j * n + i];
                if !known[j] && square > 0.0 {
                    scaling[j] = scaling[i] * cross / square;
                    if scaling[j] <= 0.0 {
                        return None;
                    }
                    known[j] = true;
                    queue.push(j);
                }
            }
        }
    }
    Some(scaling)
}

/// Symmetric to 1e-9 and without an eigenvalue below −1e-9 of the largest diagonal entry, by Cholesky elimination.
pub(crate) fn is_semidefinite(n: usize, m: &[f64], scaling: &[f64]) -> bool {
    let mut a: Vec<f64> = (0..n * n).map(|k| scaling[k / n] * m[k]).collect();
    let size = (0..n).map(|i| a[i * n + i].abs()).fold(0.0, f64::max);
    let off = |i: usize, j: usize| (a[i * n + j] - a[j * n + i]).abs();
    if (0..n).any(|i| (0..i).any(|j| off(i, j) > 1e-9 * size)) {
        return false;
    }
    for k in 0..n {
        let pivot = a[k * n + k];
        if pivot < -1e-9 * size {
            return false;
        }
        if pivot <= 1e-9 * size {
            if (k + 1..n).any(|j| a[k * n + j].abs() > 1e-4 * size) {
                return false;
            }
            continue;
        }
        for i in k + 1..n {
            let factor = a[i * n + k] / pivot;
            for j in k + 1..n {
                a[i * n + j] -= factor * a[k * n + j];
            }
        }
    }
    true
}

/// Upper bounds on the shares, or none.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Bounds(Option<Vec<f64>>);

/// Shares this close to their bound, relative, are at it.
const AT_BOUND: f64 = 1e-14;

impl Bounds {
    /// 0 ≤ w_q ≤ `upper[q]`, one bound per candidate; a bound of 1 or more has no effect.
    ///
    /// # Errors
    /// [`Error::Bound`] for a bound that is negative or not a number; [`Error::Infeasible`] if they sum to less than
    /// 1.
    pub fn new(upper: &[f64]) -> Result<Self, Error> {
        if let Some(candidate) = upper.iter().position(|u| u.is_nan() || *u < 0.0) {
            return Err(Error::Bound { candidate, found: upper[candidate] });
        }
        let upper: Vec<f64> = upper.iter().map(|u| u.min(1.0)).collect();
        let total: f64 = upper.iter().sum();
        if total < 1.0 - 1e-12 {
            return Err(Error::Infeasible { total });
        }
        Ok(Self(upper.iter().any(|u| *u < 1.0).then_some(upper)))
    }

    /// The bound of candidate `q`; infinite without bounds.
    pub fn upper(&self, q: usize) -> f64 {
        self.0.as_ref().map_or(f64::INFINITY, |upper| upper[q])
    }

    /// Whether there is a bound below 1.
    pub fn bind(&self) -> bool {
        self.0.is_some()
    }

    /// Number of bounds, if there are any.
    pub(crate) fn count(&self) -> Option<usize> {
        self.0.as_ref().map(Vec::len)
    }

    /// max Σ g_q v_q over all feasible v, less Σ g_q w_q: an upper bound on the ascent in any feasible direction.
    /// Without bounds the Kiefer–Wolfowitz gap max g_q − p.
    pub(crate) fn gap(&self, sensitivities: &[f64], shares: &[f64], degree: f64) -> f64 {
        match &self.0 {
            None => sensitivities.iter().copied().fold(f64::NEG_INFINITY, f64::max) - degree,
            Some(upper) => {
                // Relative to the level of most shares, to avoid cancellation of large sums.
                let level = self.level(sensitivities, shares, degree);
                let mut best = 0.0;
                let mut left = 1.0;
                for q in descending(sensitivities) {
                    let taken = upper[q].min(left);
                    best += taken * (sensitivities[q] - level);
                    left -= taken;
                    if left <= 0.0 {
                        break;
                    }
                }
                let reached: f64 = shares.iter().zip(sensitivities).map(|(w, g)| w * (g - level)).sum();
                best - reached
            }
        }
    }

    /// μ of the first-order conditions: g_q = μ between the bounds, ≤ μ at zero, ≥ μ at the upper bound.
    pub(crate) fn level(&self, sensitivities: &[f64], shares: &[f64], degree: f64) -> f64 {
        let Some(upper) = &self.0 else { return degree };
        let between = |q: &usize| shares[*q] > 0.0 && shares[*q] < upper[*q];
        let weight: f64 = (0..shares.len()).filter(between).map(|q| shares[q]).sum();
        if weight > 0.0 {
            let sum: f64 = (0..shares.len()).filter(between).map(|q| shares[q] * sensitivities[q]).sum();
            return sum / weight;
        }
        let of = |full: bool| {
            let chosen = move |q: &usize| upper[*q] > 0.0 && (shares[*q] > 0.0) == full;
            (0..shares.len()).filter(chosen).map(|q| sensitivities[q])
        };
        let (least, most) =
            (of(true).fold(f64::INFINITY, f64::min), of(false).fold(f64::NEG_INFINITY, f64::max));
        if most.is_finite() { 0.5 * (least + most) } else { least }
    }

    /// Scales weights to shares: min(u_q, t w_q) with the t that makes them sum to 1. What exceeds the bounds of
    /// positive weights is spread over the others in proportion to their bounds.
    pub(crate) fn fill(&self, weights: &mut [f64]) -> bool {
        let Some(upper) = &self.0 else {
            let total: f64 = weights.iter().sum();
            weights.iter_mut().for_each(|w| *w /= total);
            return total > 0.0;
        };
        let mut full = vec![false; weights.len()];
        loop {
            let left = 1.0 - sum_where(upper, |q| full[q]);
            let free = sum_where(weights, |q| !full[q]);
            if free <= 0.0 {
                let capacity = sum_where(upper, |q| !full[q]);
                let factor = if capacity > 0.0 { left / capacity } else { 0.0 };
                (0..full.len()).for_each(|q| weights[q] = if full[q] { upper[q] } else { factor * upper[q] });
                return true;
            }
            let factor = left / free;
            let before = full.iter().filter(|f| **f).count();
            (0..full.len()).for_each(|q| full[q] |= weights[q] > 0.0 && factor * weights[q] >= upper[q]);
            if full.iter().filter(|f| **f).count() == before {
                (0..full.len())
                    .for_each(|q| weights[q] = if full[q] { upper[q] } else { factor * weights[q] });
                return true;
            }
        }
    }

    /// Keeps the `count` largest of the weights below their bound, and more until their bounds sum to 1; then [`Bounds::fill`].
    pub(crate) fn keep_largest(&self, weights: &mut [f64], count: usize) {
        let mut capacity = sum_where(weights, |q| weights[q] >= self.upper(q));
        let below: Vec<f64> =
            (0..weights.len()).map(|q| if weights[q] < self.upper(q) { weights[q] } else { 0.0 }).collect();
        for (place, q) in descending(&below).into_iter().enumerate() {
            if below[q] <= 0.0 {
                break;
            }
            if place >= count && capacity >= 1.0 {
                weights[q] = 0.0;
            } else {
                capacity += self.upper(q);
            }
        }
        self.fill(weights);
    }

    /// Removes rounding from shares that sum to about 1 and are about within the bounds.
    pub(crate) fn repair(&self, shares: &mut [f64]) {
        let Some(upper) = &self.0 else {
            self.fill(shares);
            return;
        };
        for (w, u) in shares.iter_mut().zip(upper) {
            *w = if *w >= u * (1.0 - AT_BOUND) { *u } else { *w };
        }
        let excess = shares.iter().sum::<f64>() - 1.0;
        let between = |q: usize| shares[q] > 0.0 && shares[q] < upper[q];
        let weight = sum_where(shares, between);
        if weight > 0.0 {
            let factor = 1.0 - excess / weight;
            let chosen: Vec<usize> = (0..shares.len()).filter(|q| between(*q)).collect();
            chosen.into_iter().for_each(|q| shares[q] = (shares[q] * factor).min(upper[q]));
        }
    }
}

fn sum_where(values: &[f64], chosen: impl Fn(usize) -> bool) -> f64 {
    values.iter().enumerate().filter(|(q, _)| chosen(*q)).map(|(_, v)| v).sum()
}

/// Indices by descending value, the lower index first among equals.
fn descending(values: &[f64]) -> Vec<usize> {
    largest(0..values.len(), values, usize::MAX)
}

/// The `most` of the indices `places` with the largest values, in descending order, the lower index first among equals.
pub(crate) fn largest(places: impl IntoIterator<Item = usize>, values: &[f64], most: usize) -> Vec<usize> {
    let mut order: Vec<usize> = places.into_iter().collect();
    order.sort_by(|a, b| values[*b].total_cmp(&values[*a]).then(a.cmp(b)));
    order.truncate(most);
    order
}
