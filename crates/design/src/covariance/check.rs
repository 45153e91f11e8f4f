//! What candidates a criterion of the covariance is defined for, and where it is concave.

use super::{Block, Covariance, CovariancePoint, Norm};
use crate::certificate::{is_concave, row_scaling};
use crate::product::dot;
use crate::{Candidates, Error};

impl Covariance {
    /// Refuses a dictionary whose equal mixture gives a weighted direction no variance (or, for a mean of eigenvalues, none
    /// at all).
    pub(super) fn check_covariance(&self) -> Result<(), Error> {
        let count = self.information.len();
        let mut at = CovariancePoint::default();
        self.invert(&vec![1.0 / count as f64; count], &mut at)
            .ok_or_else(|| Error::Solver("equal shares are singular".into()))?;
        let weighted = self.weighted_blocks(&at);
        let nothing = weighted.iter().flatten().all(|c| *c == 0.0);
        for (index, (block, matrix)) in self.blocks().zip(&weighted).enumerate() {
            let k = block.kept();
            if k == 0 || (self.norm != Norm::LogDet && !nothing) {
                continue;
            }
            // In correlations, so that units do not count.
            let size = |i: usize| matrix[i * k + i].max(0.0).sqrt();
            let zero = (0..k).find(|i| size(*i) == 0.0);
            let direction = match zero {
                Some(i) => (0..k).map(|j| f64::from(u8::from(i == j))).collect(),
                None => {
                    let correlation: Vec<f64> =
                        (0..k * k).map(|e| matrix[e] / (size(e / k) * size(e % k))).collect();
                    match numerics::weakest(k, &correlation) {
                        Some(found) if found.ratio > 1e-12 => continue,
                        Some(found) => found.direction,
                        None => vec![1.0; k],
                    }
                }
            };
            return Err(Error::SingularCovariance { block: index, row: strongest(&block, &direction) });
        }
        Ok(())
    }
}

/// The row that a direction in weighted units has most of.
fn strongest(block: &Block<'_>, direction: &[f64]) -> usize {
    let n = block.n;
    let part =
        |i: usize| direction.iter().enumerate().map(|(e, x)| x * block.root[e * n + i]).sum::<f64>().abs();
    (0..n).max_by(|a, b| part(*a).total_cmp(&part(*b))).unwrap_or(0)
}

/// Whether every B_q is one multiple, per block, of the information in symmetric form.
pub(super) fn is_proportional(information: &Candidates, middle: &Candidates) -> bool {
    if !is_concave(information) {
        return false;
    }
    information.blocks().all(|(n, range)| {
        let matrices = (0..information.len()).map(|q| &information.candidate(q)[range.clone()]);
        let Some(factors) = row_scaling(n, matrices) else { return false };
        // A D with A = Mᵀ: instrument i is d_i times regressor i.
        let symmetric = |q: usize| -> Vec<f64> {
            let m = &information.candidate(q)[range.clone()];
            (0..n * n).map(|e| factors[e / n] * m[e]).collect()
        };
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
    })
}
