use crate::{Candidates, Evaluation};

/// What is maximised over shares: a function Φ of the mixture of candidates with Φ(tw) = Φ(w) + degree · log t, so that
/// Σ_q w_q g_q is the degree.
pub trait Objective {
    /// The value and what the derivatives need, reused over evaluations.
    type Point: Default;

    /// Number of candidates Q.
    fn len(&self) -> usize;

    /// Whether there is no candidate.
    fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Σ_q w_q g_q at any shares.
    fn degree(&self) -> f64;

    /// Numbers per candidate: no optimal support needs more shares between their bounds.
    fn size(&self) -> usize;

    /// Exponent of multiplicative steps w_q ← w_q g_q^κ.
    fn exponent(&self) -> f64;

    /// Φ(w) with the ingredients of the derivatives. `None` where it is not defined.
    fn evaluate(&self, shares: &[f64], at: &mut Self::Point) -> Option<f64>;

    /// Φ(w) alone. `None` where it is not defined.
    fn value(&self, shares: &[f64], at: &mut Self::Point) -> Option<f64>;

    /// g_q = ∂Φ/∂w_q at an evaluated point.
    fn sensitivity(&self, q: usize, at: &Self::Point) -> f64;

    /// −∂²Φ/∂w_q∂w_r at an evaluated point, members × members, row-major.
    fn curvature(&self, members: &[usize], at: &Self::Point) -> Vec<f64>;
}

/// The D-criterion of the information matrix, Σ_b log|det M_b(w)|.
impl Objective for Candidates {
    type Point = Evaluation;

    fn len(&self) -> usize {
        Self::len(self)
    }

    fn degree(&self) -> f64 {
        self.dimension() as f64
    }

    fn size(&self) -> usize {
        Self::size(self)
    }

    fn exponent(&self) -> f64 {
        1.0
    }

    fn evaluate(&self, shares: &[f64], at: &mut Evaluation) -> Option<f64> {
        Self::evaluate(self, shares, at)
    }

    fn value(&self, shares: &[f64], at: &mut Evaluation) -> Option<f64> {
        self.log_abs_det(shares, at)
    }

    fn sensitivity(&self, q: usize, at: &Evaluation) -> f64 {
        Self::sensitivity(self, q, at)
    }

    fn curvature(&self, members: &[usize], at: &Evaluation) -> Vec<f64> {
        curvature(self, members, at)
    }
}

/// −∂²/∂w_q∂w_r Σ_b log|det M_b| = Σ_b tr(M⁻¹ M_q M⁻¹ M_r), members × members.
fn curvature(candidates: &Candidates, members: &[usize], at: &Evaluation) -> Vec<f64> {
    let size = candidates.size();
    let (mut products, mut transposed) = (vec![0.0; members.len() * size], vec![0.0; members.len() * size]);
    for (m, q) in members.iter().enumerate() {
        let entries = candidates.candidate(*q);
        for (n, range) in candidates.blocks() {
            let inverse_t = &at.inverse_transposed[range.clone()];
            let matrix = &entries[range.clone()];
            for i in 0..n {
                for j in 0..n {
                    let product: f64 = (0..n).map(|k| inverse_t[k * n + i] * matrix[k * n + j]).sum();
                    products[m * size + range.start + i * n + j] = product;
                    transposed[m * size + range.start + j * n + i] = product;
                }
            }
        }
    }
    let mut curvature = vec![0.0; members.len() * members.len()];
    for (q, row) in products.chunks_exact(size).enumerate() {
        for (r, column) in transposed.chunks_exact(size).enumerate() {
            curvature[q * members.len() + r] = row.iter().zip(column).map(|(a, b)| a * b).sum();
        }
    }
    curvature
}
