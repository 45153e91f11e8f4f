//! The criterion with its first and second derivatives.

use numerics::{congruence, dot, product, transposed};

use super::block::Block;
use super::{Covariance, CovariancePoint};
use crate::spectrum::Spectrum;
use crate::{Norm, Objective};

impl Objective for Covariance {
    type Point = CovariancePoint;

    fn len(&self) -> usize {
        self.information.len()
    }

    fn degree(&self) -> f64 {
        match self.norm {
            Norm::LogDet => self.eigenvalues() as f64,
            Norm::Trace => 1.0,
        }
    }

    fn size(&self) -> usize {
        self.information.size()
    }

    fn exponent(&self) -> f64 {
        match self.norm {
            Norm::LogDet => 1.0,
            Norm::Trace => 0.5,
        }
    }

    fn value(&self, shares: &[f64], at: &mut CovariancePoint) -> Option<f64> {
        self.invert(shares, at)?;
        let weighted = self.weighted_blocks(at);
        Some(-self.offset - crate::spectrum::value(self.norm, &weighted)?)
    }

    fn evaluate(&self, shares: &[f64], at: &mut CovariancePoint) -> Option<f64> {
        self.invert(shares, at)?;
        let spectrum = Spectrum::of(self.norm, &self.weighted_blocks(at))?;
        at.slopes.iter_mut().for_each(Vec::clear);
        for (block, slope) in self.blocks().zip(&spectrum.slopes) {
            let n = block.n;
            let inverse = &at.inverse[block.range.clone()];
            let weight = block.unweighted(slope);
            // dΦ = 2 tr(S A⁻¹ dA C) − tr(A⁻ᵀ S A⁻¹ dB), S = ∂norm/∂C.
            let left = product(n, &weight, inverse);
            let of_m = product(n, &at.covariance[block.range.clone()], &left);
            let of_b = product(n, &transposed(n, inverse), &left);
            at.slopes[0].extend(of_m.iter().map(|x| 2.0 * x));
            at.slopes[1].extend(of_b.iter().map(|x| -x));
        }
        let value = -self.offset - spectrum.value;
        at.spectrum = spectrum;
        Some(value)
    }

    fn sensitivity(&self, q: usize, at: &CovariancePoint) -> f64 {
        dot(&at.slopes[0], self.information.candidate(q)) + dot(&at.slopes[1], self.meat.candidate(q))
    }

    fn curvature(&self, members: &[usize], at: &CovariancePoint) -> Vec<f64> {
        let first: Vec<f64> = members.iter().map(|q| -self.sensitivity(*q, at)).collect();
        let mut moved: Vec<Vec<Vec<f64>>> = Vec::new();
        let k = members.len();
        let mut curvature = vec![0.0; k * k];
        for (block, slope) in self.blocks().zip(&at.spectrum.slopes) {
            let weight = block.unweighted(slope);
            let changes: Vec<Change> = members.iter().map(|q| self.change(&block, &weight, *q, at)).collect();
            for (q, a) in changes.iter().enumerate() {
                // Symmetric: tr S U C U'ᵀ too, since S and C are.
                for (r, b) in changes.iter().enumerate().skip(q) {
                    let mixed = dot(&b.weighted, &a.pulled)
                        + dot(&a.weighted, &b.pulled)
                        + dot(&a.twisted, &b.relative);
                    curvature[q * k + r] += 2.0 * mixed;
                    if r > q {
                        curvature[r * k + q] += 2.0 * mixed;
                    }
                }
            }
            moved.push(changes.into_iter().map(|c| c.covariance).collect());
        }
        at.spectrum.add_curvature(&moved, &first, &mut curvature);
        curvature
    }
}

/// The change of the covariance of a block with one candidate's share: U = A⁻¹ A_q, V = A⁻¹ B_q A⁻ᵀ.
struct Change {
    /// U.
    relative: Vec<f64>,
    /// S U.
    weighted: Vec<f64>,
    /// S U C.
    twisted: Vec<f64>,
    /// (U C)ᵀ − V.
    pulled: Vec<f64>,
    /// The weighted covariance's derivative −U C − C Uᵀ + V.
    covariance: Vec<f64>,
}

impl Covariance {
    fn change(&self, block: &Block<'_>, weight: &[f64], q: usize, at: &CovariancePoint) -> Change {
        let n = block.n;
        let inverse = &at.inverse[block.range.clone()];
        let covariance = &at.covariance[block.range.clone()];
        let information = transposed(n, &self.information.candidate(q)[block.range.clone()]);
        let relative = product(n, inverse, &information);
        let meat = congruence(n, inverse, &self.meat.candidate(q)[block.range.clone()]);
        let weighted = product(n, weight, &relative);
        let twisted = product(n, &weighted, covariance);
        let turned = product(n, &relative, covariance);
        let pulled = (0..n * n).map(|e| turned[(e % n) * n + e / n] - meat[e]).collect();
        let whole: Vec<f64> = (0..n * n).map(|e| meat[e] - turned[e] - turned[(e % n) * n + e / n]).collect();
        Change { relative, weighted, twisted, pulled, covariance: block.weighted(&whole) }
    }
}
