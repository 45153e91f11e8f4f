//! Checks whether a criterion of the covariance is defined, and whether it is concave.

use numerics::dot;

use super::block::Block;
use crate::Candidates;
use crate::certificate::{is_concave, row_scaling};

/// The dominant row of a direction without variance in the weighted covariance `matrix` of a block, if there is one.
pub(super) fn row_without_variance(block: &Block<'_>, matrix: &[f64]) -> Option<usize> {
    let k = block.kept();
    if k == 0 {
        return None;
    }
    // In correlations, so that units do not matter.
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

/// The dominant row of a direction in weighted units.
fn strongest(block: &Block<'_>, direction: &[f64]) -> usize {
    let n = block.n;
    let part =
        |i: usize| direction.iter().enumerate().map(|(e, x)| x * block.root[e * n + i]).sum::<f64>().abs();
    (0..n).max_by(|a, b| part(*a).total_cmp(&part(*b))).unwrap_or(0)
}

/// Whether every B_q is the same multiple, per block, of the information in symmetric form, which is semidefinite.
pub(super) fn is_proportional(information: &Candidates, meat: &Candidates) -> bool {
    let proportional = information.blocks().all(|(n, range)| {
        let matrices = (0..information.len()).map(|q| &information.candidate(q)[range.clone()]);
        let Some(factors) = row_scaling(n, matrices) else { return false };
        // A D with A = Mᵀ: instrument i is d_i times regressor i.
        let symmetric = |q: usize| -> Vec<f64> {
            let m = &information.candidate(q)[range.clone()];
            (0..n * n).map(|e| factors[e / n] * m[e]).collect()
        };
        let all = (0..information.len()).map(|q| &meat.candidate(q)[range.clone()]);
        if !is_multiple(&symmetric(0), &meat.candidate(0)[range.clone()], all) {
            return false;
        }
        let (mut own, mut cross, mut total) = (0.0, 0.0, 0.0);
        for q in 0..information.len() {
            let (s, b) = (symmetric(q), &meat.candidate(q)[range.clone()]);
            own += dot(&s, &s);
            cross += dot(&s, b);
            total += dot(b, b);
        }
        let factor = cross / own;
        let left: f64 = (0..information.len())
            .map(|q| {
                let (s, b) = (symmetric(q), &meat.candidate(q)[range.clone()]);
                s.iter().zip(b).map(|(s, b)| (b - factor * s).powi(2)).sum::<f64>()
            })
            .sum();
        factor > 0.0 && left <= 1e-18 * total
    });
    proportional && is_concave(information)
}

/// Whether `b` may be a multiple of `s`, as `all` are: a cheap check that leaves few candidates for a full one.
fn is_multiple<'a>(s: &[f64], b: &[f64], all: impl Iterator<Item = &'a [f64]>) -> bool {
    let factor = dot(s, b) / dot(s, s);
    let left: f64 = s.iter().zip(b).map(|(s, b)| (b - factor * s).powi(2)).sum();
    left <= 1e-9 * all.map(|b| dot(b, b)).sum::<f64>() || !left.is_finite()
}
