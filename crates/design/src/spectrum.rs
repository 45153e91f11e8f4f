use std::ops::Range;

use numerics::{dot, product, symmetric, transposed};

use crate::Candidates;
use crate::certificate::{is_concave, row_scaling};

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

/// The norm of a covariance matrix that is minimised.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Norm {
    /// log det: D-optimality.
    #[default]
    LogDet,
    /// log of the trace: A-optimality.
    Trace,
}

/// The rows of one block: `range` in the matrices, `rows` over all blocks; the root V of its weights, k × n.
pub(crate) struct Block<'a> {
    pub n: usize,
    pub range: Range<usize>,
    pub rows: Range<usize>,
    pub root: &'a [f64],
}

impl Block<'_> {
    /// Rows of the root.
    pub fn kept(&self) -> usize {
        self.root.len() / self.n.max(1)
    }

    /// V C Vᵀ, k × k.
    pub fn weighted(&self, matrix: &[f64]) -> Vec<f64> {
        let (n, k) = (self.n, self.kept());
        let mut half = vec![0.0; k * n];
        multiply(k, n, self.root, matrix, &mut half);
        let rows = |i: usize| &half[i * n..(i + 1) * n];
        let root = |j: usize| &self.root[j * n..(j + 1) * n];
        (0..k * k).map(|e| dot(rows(e / k), root(e % k))).collect()
    }

    /// Vᵀ K V, n × n.
    pub fn unweighted(&self, kept: &[f64]) -> Vec<f64> {
        let (n, k) = (self.n, self.kept());
        let mut half = vec![0.0; k * n];
        multiply(k, k, kept, self.root, &mut half);
        let mut out = vec![0.0; n * n];
        for (row, root) in half.chunks_exact(n).zip(self.root.chunks_exact(n)) {
            for (line, r) in out.chunks_exact_mut(n).zip(root).filter(|(_, r)| **r != 0.0) {
                line.iter_mut().zip(row).for_each(|(o, x)| *o += r * x);
            }
        }
        out
    }
}

/// A B of a rows × m and an m × n matrix; zeros in A are skipped.
fn multiply(rows: usize, m: usize, a: &[f64], b: &[f64], out: &mut [f64]) {
    let n = out.len() / rows.max(1);
    for (line, left) in out.chunks_exact_mut(n.max(1)).zip(a.chunks_exact(m.max(1))) {
        for (factor, right) in left.iter().zip(b.chunks_exact(n.max(1))).filter(|(f, _)| **f != 0.0) {
            line.iter_mut().zip(right).for_each(|(o, r)| *o += factor * r);
        }
    }
}

/// The dominant row of a direction without variance in the weighted covariance `matrix` of a block, if there is one.
pub(crate) fn row_without_variance(block: &Block<'_>, matrix: &[f64]) -> Option<usize> {
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
                Some(weakest) if weakest.ratio > 1e-12 => return None,
                Some(weakest) => weakest.direction,
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
pub(crate) fn is_proportional(information: &Candidates, meat: &Candidates) -> bool {
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
        let (mut square, mut cross, mut total) = (0.0, 0.0, 0.0);
        for q in 0..information.len() {
            let (s, b) = (symmetric(q), &meat.candidate(q)[range.clone()]);
            square += dot(&s, &s);
            cross += dot(&s, b);
            total += dot(b, b);
        }
        let factor = cross / square;
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
