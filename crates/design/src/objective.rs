use numerics::{dot, product, transposed};

use crate::{Candidates, Evaluation};

/// The objective, maximised over shares: a function Φ of the mixture of candidates with Φ(tw) = Φ(w) + degree · log
/// t, so that Σ_q w_q g_q is the degree.
pub trait Objective {
    /// The value and the workspace of the derivatives, reused over evaluations.
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

    /// Φ(w), and the workspace of the derivatives. `None` if it is not defined.
    fn evaluate(&self, shares: &[f64], at: &mut Self::Point) -> Option<f64>;

    /// Φ(w) alone. `None` if it is not defined.
    fn value(&self, shares: &[f64], at: &mut Self::Point) -> Option<f64>;

    /// g_q = ∂Φ/∂w_q at an evaluated point.
    fn sensitivity(&self, q: usize, at: &Self::Point) -> f64;

    /// g_q of all candidates.
    fn sensitivities(&self, at: &Self::Point) -> Vec<f64> {
        (0..self.len()).map(|q| self.sensitivity(q, at)).collect()
    }

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
        self.sum(shares, &mut at.sum);
        at.inverse.resize(self.size(), 0.0);
        at.inverse_transposed.clear();
        at.log_det = 0.0;
        let mut regular = true;
        for (n, range) in self.blocks() {
            match numerics::inverse_and_log_det(n, &mut at.sum[range.clone()], &mut at.inverse[range.clone()])
            {
                Some(det) => at.log_det += det.log_abs,
                None => regular = false,
            }
            at.inverse_transposed.extend(transposed(n, &at.inverse[range]));
        }
        regular.then_some(at.log_det)
    }

    fn value(&self, shares: &[f64], at: &mut Evaluation) -> Option<f64> {
        self.sum(shares, &mut at.sum);
        let mut sum = 0.0;
        for (n, range) in self.blocks() {
            sum += numerics::log_det(n, &mut at.sum[range])?.log_abs;
        }
        Some(sum)
    }

    /// g_q = Σ_b tr(M_b(w)⁻¹ M_q,b).
    fn sensitivity(&self, q: usize, at: &Evaluation) -> f64 {
        dot(&at.inverse_transposed, self.candidate(q))
    }

    /// Σ_b tr(M⁻¹ M_q M⁻¹ M_r).
    fn curvature(&self, members: &[usize], at: &Evaluation) -> Vec<f64> {
        let (mut products, mut turned) = (Vec::new(), Vec::new());
        for q in members {
            let entries = self.candidate(*q);
            for (n, range) in self.blocks() {
                let inverse = transposed(n, &at.inverse_transposed[range.clone()]);
                let relative = product(n, &inverse, &entries[range]);
                turned.extend(transposed(n, &relative));
                products.extend(relative);
            }
        }
        let rows = || products.chunks_exact(self.size());
        let columns = || turned.chunks_exact(self.size());
        rows().flat_map(|row| columns().map(|column| dot(row, column))).collect()
    }
}
