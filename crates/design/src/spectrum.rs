use crate::Norm;
use crate::eigen::symmetric;
use crate::product::{dot, product, transposed};

/// The norm of a block-diagonal covariance with its first two derivatives.
#[derive(Clone, Debug, Default)]
pub(crate) struct Spectrum {
    /// The norm.
    pub value: f64,
    blocks: Vec<Eigen>,
    /// Exponent of the power mean; none for log det.
    power: Option<f64>,
}

#[derive(Clone, Debug, Default)]
struct Eigen {
    k: usize,
    values: Vec<f64>,
    vectors: Vec<f64>,
    /// Derivative of the norm by each eigenvalue.
    slopes: Vec<f64>,
}

/// The norm alone.
pub(crate) fn value(norm: Norm, blocks: &[Vec<f64>]) -> Option<f64> {
    match norm {
        Norm::LogDet => blocks.iter().try_fold(0.0, |sum, block| {
            let det = numerics::log_det(block.len().isqrt(), &mut block.clone())?;
            (det.sign > 0.0).then_some(sum + det.log_abs)
        }),
        Norm::PowerMean(1.0) => {
            let trace = |b: &Vec<f64>| b.iter().step_by(b.len().isqrt() + 1).sum::<f64>();
            let sum: f64 = blocks.iter().map(trace).sum();
            (sum > 0.0).then(|| sum.ln())
        }
        norm => Spectrum::of(norm, blocks.to_vec()).map(|s| s.value),
    }
}

impl Spectrum {
    /// `None` where the norm is not defined: no positive eigenvalue, or for log det one that is not positive.
    pub(crate) fn of(norm: Norm, matrices: Vec<Vec<f64>>) -> Option<Self> {
        let eigen = |matrix: &Vec<f64>| {
            let k = matrix.len().isqrt();
            let (values, vectors) = symmetric(k, matrix);
            let values = values.into_iter().map(|v| v.max(0.0)).collect();
            Eigen { k, values, vectors, slopes: Vec::new() }
        };
        let mut blocks: Vec<Eigen> = matrices.iter().map(eigen).collect();
        match norm {
            Norm::LogDet => {
                let value: f64 = blocks.iter().flat_map(|b| &b.values).map(|v| v.ln()).sum();
                for block in &mut blocks {
                    block.slopes = block.values.iter().map(|v| 1.0 / v).collect();
                }
                value.is_finite().then_some(Self { value, blocks, power: None })
            }
            Norm::PowerMean(power) => {
                let largest = blocks.iter().flat_map(|b| &b.values).copied().fold(0.0, f64::max);
                if !(largest > 0.0 && largest.is_finite()) {
                    return None;
                }
                let sum: f64 = blocks.iter().flat_map(|b| &b.values).map(|v| (v / largest).powf(power)).sum();
                for block in &mut blocks {
                    let slope = |v: &f64| (v / largest).powf(power - 1.0) / (largest * sum);
                    block.slopes = block.values.iter().map(slope).collect();
                }
                Some(Self { value: largest.ln() + sum.ln() / power, blocks, power: Some(power) })
            }
        }
    }

    /// ∂norm/∂C of each block.
    pub(crate) fn slopes(&self) -> impl Iterator<Item = Vec<f64>> + '_ {
        self.blocks.iter().map(|block| {
            let k = block.k;
            let entry = |i: usize, j: usize| {
                (0..k).map(|e| block.vectors[i * k + e] * block.slopes[e] * block.vectors[j * k + e]).sum()
            };
            (0..k * k).map(|e| entry(e / k, e % k)).collect()
        })
    }

    /// Adds the norm's own second derivative along the changes C_q, C_r of the covariance to `curvature`. `changes`: per
    /// block and member; `first`: the norm's derivative by each member.
    pub(crate) fn add_curvature(&self, changes: &[Vec<Vec<f64>>], first: &[f64], curvature: &mut [f64]) {
        let members = first.len();
        for (block, changes) in self.blocks.iter().zip(changes) {
            let k = block.k;
            let vectors_t = transposed(k, &block.vectors);
            let turned: Vec<Vec<f64>> =
                changes.iter().map(|c| product(k, &product(k, &vectors_t, c), &block.vectors)).collect();
            let quotients: Vec<f64> = (0..k * k).map(|e| block.quotient(e / k, e % k, self.power)).collect();
            let scaled: Vec<Vec<f64>> =
                turned.iter().map(|t| t.iter().zip(&quotients).map(|(t, h)| t * h).collect()).collect();
            for (q, a) in scaled.iter().enumerate() {
                for (r, b) in turned.iter().enumerate() {
                    curvature[q * members + r] += dot(a, b);
                }
            }
        }
        if let Some(power) = self.power {
            for q in 0..members {
                for r in 0..members {
                    curvature[q * members + r] -= power * first[q] * first[r];
                }
            }
        }
    }
}

impl Eigen {
    /// (ψ_i − ψ_j)/(λ_i − λ_j) of the slopes ψ, and its limit for equal eigenvalues.
    fn quotient(&self, i: usize, j: usize, power: Option<f64>) -> f64 {
        let (a, b) = (self.values[i].max(self.values[j]), self.values[i].min(self.values[j]));
        match power {
            None => -1.0 / (a * b),
            Some(1.0) => 0.0,
            Some(power) => {
                let top = self.slopes[i].max(self.slopes[j]);
                let gap = (a - b) / a;
                if gap <= 0.0 {
                    return if a > 0.0 { (power - 1.0) * top / a } else { 0.0 };
                }
                // ψ_j = ψ_i (λ_j/λ_i)^(s−1)
                let fall = if b > 0.0 { -((power - 1.0) * (-gap).ln_1p()).exp_m1() } else { 1.0 };
                top * fall / (a * gap)
            }
        }
    }
}
