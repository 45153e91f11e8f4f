use numerics::{dot, product, transposed};

use crate::Norm;
use crate::eigen::symmetric;

/// The norm of a block-diagonal covariance with its first two derivatives.
#[derive(Clone, Debug, Default)]
pub(crate) struct Spectrum {
    /// The norm.
    pub value: f64,
    blocks: Vec<Eigen>,
    norm: Norm,
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
        Norm::Trace => {
            let trace = |b: &Vec<f64>| b.iter().step_by(b.len().isqrt() + 1).sum::<f64>();
            let sum: f64 = blocks.iter().map(trace).sum();
            (sum > 0.0).then(|| libm::log(sum))
        }
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
                let value: f64 = blocks.iter().flat_map(|b| &b.values).map(|v| libm::log(*v)).sum();
                for block in &mut blocks {
                    block.slopes = block.values.iter().map(|v| 1.0 / v).collect();
                }
                value.is_finite().then_some(Self { value, blocks, norm })
            }
            Norm::Trace => {
                // Relative to the largest eigenvalue, so that nothing overflows.
                let largest = blocks.iter().flat_map(|b| &b.values).copied().fold(0.0, f64::max);
                if !(largest > 0.0 && largest.is_finite()) {
                    return None;
                }
                let sum: f64 = blocks.iter().flat_map(|b| &b.values).map(|v| v / largest).sum();
                for block in &mut blocks {
                    block.slopes = vec![1.0 / (largest * sum); block.k];
                }
                Some(Self { value: libm::log(largest) + libm::log(sum), blocks, norm })
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
        match self.norm {
            // The trace is linear; only its logarithm bends.
            Norm::Trace => {
                for (q, a) in first.iter().enumerate() {
                    for (r, b) in first.iter().enumerate() {
                        curvature[q * members + r] -= a * b;
                    }
                }
            }
            Norm::LogDet => {
                for (block, changes) in self.blocks.iter().zip(changes) {
                    block.add_log_det_curvature(changes, curvature);
                }
            }
        }
    }
}

impl Eigen {
    /// −tr(C⁻¹ C_q C⁻¹ C_r) of all members.
    fn add_log_det_curvature(&self, changes: &[Vec<f64>], curvature: &mut [f64]) {
        let (k, members) = (self.k, changes.len());
        let vectors_t = transposed(k, &self.vectors);
        let turned: Vec<Vec<f64>> =
            changes.iter().map(|c| product(k, &product(k, &vectors_t, c), &self.vectors)).collect();
        let inverse = |i: usize, j: usize| {
            let (a, b) = (self.values[i].max(self.values[j]), self.values[i].min(self.values[j]));
            -1.0 / (a * b)
        };
        let quotients: Vec<f64> = (0..k * k).map(|e| inverse(e / k, e % k)).collect();
        let scaled: Vec<Vec<f64>> =
            turned.iter().map(|t| t.iter().zip(&quotients).map(|(t, h)| t * h).collect()).collect();
        for (q, a) in scaled.iter().enumerate() {
            for (r, b) in turned.iter().enumerate() {
                curvature[q * members + r] += dot(a, b);
            }
        }
    }
}
