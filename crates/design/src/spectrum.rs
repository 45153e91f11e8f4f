use numerics::{dot, product, symmetric, transposed};

use crate::Norm;

/// The norm of a block-diagonal covariance with its first two derivatives.
#[derive(Clone, Debug, Default)]
pub(crate) struct Spectrum {
    /// The norm.
    pub value: f64,
    /// ∂norm/∂C of each block.
    pub slopes: Vec<Vec<f64>>,
    /// The eigenvalues, for a [`Norm::LogDet`].
    blocks: Vec<Eigen>,
    norm: Norm,
}

#[derive(Clone, Debug, Default)]
struct Eigen {
    k: usize,
    values: Vec<f64>,
    vectors: Vec<f64>,
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
    /// `None` if the norm is not defined: no variance, or for log det an eigenvalue that is not positive.
    pub(crate) fn of(norm: Norm, matrices: &[Vec<f64>]) -> Option<Self> {
        match norm {
            Norm::LogDet => {
                let blocks: Vec<Eigen> = matrices.iter().map(|matrix| Eigen::of(matrix)).collect();
                let value: f64 = blocks.iter().flat_map(|b| &b.values).map(|v| libm::log(*v)).sum();
                let slopes = blocks.iter().map(Eigen::inverse).collect();
                value.is_finite().then_some(Self { value, slopes, blocks, norm })
            }
            Norm::Trace => {
                let value = value(norm, matrices).filter(|value| value.is_finite())?;
                let share = libm::exp(-value);
                let identity = |matrix: &Vec<f64>| {
                    let k = matrix.len().isqrt();
                    (0..k * k).map(|e| if e % (k + 1) == 0 { share } else { 0.0 }).collect()
                };
                let slopes = matrices.iter().map(identity).collect();
                Some(Self { value, slopes, blocks: Vec::new(), norm })
            }
        }
    }

    /// Adds the norm's own second derivative along the changes C_q, C_r of the covariance to `curvature`. `changes`: per
    /// block and member; `first`: the norm's derivative by each member.
    pub(crate) fn add_curvature(&self, changes: &[Vec<Vec<f64>>], first: &[f64], curvature: &mut [f64]) {
        let members = first.len();
        match self.norm {
            // The trace is linear; only its logarithm is curved.
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
    fn of(matrix: &[f64]) -> Self {
        let k = matrix.len().isqrt();
        // Without finite entries the norm is not defined.
        let (values, vectors) = symmetric(k, matrix).unwrap_or_else(|| (vec![0.0; k], vec![0.0; k * k]));
        Self { k, values: values.into_iter().map(|v| v.max(0.0)).collect(), vectors }
    }

    /// C⁻¹.
    fn inverse(&self) -> Vec<f64> {
        let k = self.k;
        let entry = |i: usize, j: usize| {
            (0..k).map(|e| self.vectors[i * k + e] / self.values[e] * self.vectors[j * k + e]).sum()
        };
        (0..k * k).map(|e| entry(e / k, e % k)).collect()
    }

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
