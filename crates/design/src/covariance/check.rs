//! What candidates a criterion of the covariance is defined for, and where it is concave.

use numerics::dot;

use super::block::Block;
use crate::Candidates;
use crate::certificate::{is_concave, row_scaling};

/// The row that a direction without variance has most of, where the weighted covariance `matrix` of a block has such a one.
pub(super) fn row_without_variance(block: &Block<'_>, matrix: &[f64]) -> Option<usize> {
    let k = block.kept();
    if k == 0 {
        return None;
    }
    // In correlations, so that units do not count.
    let size = |i: usize| matrix[i * k + i].max(0.0).sqrt();
    let direction = match (0..k).find(|i| size(*i) == 0.0) {
        Some(i) => (0..k).map(|j| f64::from(u8::from(i == j))).collect(),
        None => {
            let correlation: Vec<f64> = (0..k * k).map(|e| matrix[e] / (size(e / k) * size(e % k))).collect();
            match numerics::weakest(k, &correlation) {
                Some(found) if found.ratio > 1e-12 => return None,
                Some(found) => found.direction,
                None => vec![1.0; k],
            }
        }
    };
    Some(strongest(block, &direction))
}

/// The row that a direction in weighted units has most of.
fn strongest(block: &Block<'_>, direction: &[f64]) -> usize {
    let n = block.n;
    let part =
        |i: usize| direction.iter().enumerate().map(|(e, x)| x * block.root[e * n + i]).sum::<f64>().abs();
    (0..n).max_by(|a, b| part(*a).total_cmp(&part(*b))).unwrap_or(0)
}

/// Whether every B_q is one multiple, per block, of the information in symmetric form, which is semidefinite.
pub(super) fn is_proportional(information: &Candidates, middle: &Candidates) -> bool {
    let proportional = information.blocks().all(|(n, range)| {
        let matrices = (0..information.len()).map(|q| &information.candidate(q)[range.clone()]);
        let Some(factors) = row_scaling(n, matrices) else { return false };
        // A D with A = Mᵀ: instrument i is d_i times regressor i.
        let symmetric = |q: usize| -> Vec<f64> {
            let m = &information.candidate(q)[range.clone()];
            (0..n * n).map(|e| factors[e / n] * m[e]).collect()
        };
        let all = (0..information.len()).map(|q| &middle.candidate(q)[range.clone()]);
        if !is_multiple(&symmetric(0), &middle.candidate(0)[range.clone()], all) {
            return false;
        }
        let (mut own, mut cross, mut total) = (0.0, 0.0, 0.0);
        for q in 0..information.len() {
            let (s, b) = (symmetric(q), &middle.candidate(q)[range.clone()]);
            own += dot(&s, &s);
            cross += dot(&s, b);
            total += dot(b, b);
        }
        let factor = cross / own;
        let left: f64 = (0..information.len())
            .map(|q| {
                let (s, b) = (symmetric(q), &middle.candidate(q)[range.clone()]);
                s.iter().zip(b).map(|(s, b)| (b - factor * s).powi(2)).sum::<f64>()
            })
            .sum();
        factor > 0.0 && left <= 1e-18 * total
    });
    proportional && is_concave(information)
}

/// Whether `b` may be a multiple of `s`, beside `all` that are: a look that costs little and leaves few to be looked at closely.
fn is_multiple<'a>(s: &[f64], b: &[f64], all: impl Iterator<Item = &'a [f64]>) -> bool {
    let factor = dot(s, b) / dot(s, s);
    let left: f64 = s.iter().zip(b).map(|(s, b)| (b - factor * s).powi(2)).sum();
    left <= 1e-9 * all.map(|b| dot(b, b)).sum::<f64>() || !left.is_finite()
}
