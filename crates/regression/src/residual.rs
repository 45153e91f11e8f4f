//! The contribution of the residuals to the covariance of an estimate.
//!
//! θ̂ − θ = A⁻¹ Σ ζᶜ(k) ε(k). The residual contains e(k+1) − e(k), so it is correlated with its neighbours: its
//! autocovariances γ₀, γ₁ are those of the likeliest moving average of order one.

use numerics::Lane;

use crate::batch::{AnyBatch, over_batch};
use crate::groups::Groups;
use crate::spans::{self, Kept};

/// Per degree of freedom Σ ζᶜζᶜᵀ and Σ (ζᶜ(k−1) ζᶜ(k)ᵀ + its transpose), upper triangles.
pub(crate) struct InstrumentSquares {
    pub squares: Vec<Lane>,
    pub neighbours: Vec<Lane>,
}

impl InstrumentSquares {
    /// `kept` is ζ, if stored. `means`: the instruments' means per run and group.
    pub(crate) fn over(batch: AnyBatch, kept: &Kept, means: Groups) -> Self {
        let model = batch.model();
        let triangles = model.degrees.iter().map(|d| d.terms.len() * (d.terms.len() + 1) / 2).sum();
        let zeros = || vec![Lane::ZERO; triangles];
        let mut sums = Self { squares: zeros(), neighbours: zeros() };
        over_batch!(batch, |batch| {
            spans::add_squares(&batch, kept, means, [&mut sums.squares, &mut sums.neighbours]);
        });
        sums
    }
}

/// The residuals of `theta`, one lane per parameter: surge, sway, yaw. `kept` is ζ, if stored. `intercepts`: three per
/// run and group.
pub(crate) fn residuals(batch: AnyBatch, kept: &Kept, theta: &[Lane], intercepts: Groups) -> [Vec<Lane>; 3] {
    let mut all = [const { Vec::new() }; 3];
    over_batch!(batch, |batch| {
        spans::put_residuals(&batch, kept, theta, intercepts, &mut all);
    });
    all
}
