//! The covariance of the residuals' part in an estimate.
//!
//! θ̂ − θ = A⁻¹ Σ ζᶜ(k) ε(k). The residual contains e(k+1) − e(k), so it is correlated with its neighbours: it is taken as
//! a moving average of order one with autocovariances γ₀, γ₁, and |γ₁| ≤ γ₀/2 as every such process has.

use vessel::{Lane, Number, Structure};

use crate::batch::{AnyBatch, BLOCK, over_batch, parts};
use crate::groups::{Constants, Groups};
use crate::lags::Lags;
use crate::spans::{self, Kept};
use crate::{Batch, structured};

/// Per degree of freedom Σ ζᶜζᶜᵀ and Σ (ζᶜ(k−1) ζᶜ(k)ᵀ + its transpose), upper triangles.
pub(crate) struct InstrumentSquares {
    pub squares: Vec<Lane>,
    pub neighbours: Vec<Lane>,
}

impl InstrumentSquares {
    /// `kept` is ζ, where it was kept. `means`: the instruments' means per run and group.
    pub(crate) fn over(batch: AnyBatch, kept: &Kept, means: Groups) -> Self {
        let model = batch.model();
        let triangles = model.degrees.iter().map(|d| d.terms.len() * (d.terms.len() + 1) / 2).sum();
        let zeros = || vec![Lane::ZERO; triangles];
        let mut sums = Self { squares: zeros(), neighbours: zeros() };
        match model.structure() {
            Some(known) => over_batch!(batch, |batch| sums.add_known(known, &batch, means)),
            None => over_batch!(batch, |batch| {
                spans::add_squares(&batch, kept, means, [&mut sums.squares, &mut sums.neighbours]);
            }),
        }
        sums
    }

    #[inline(always)]
    fn add_known<X: Number, const V: usize, const P: usize>(
        &mut self,
        structure: impl Structure<V, P>,
        batch: &Batch<X>,
        means: Groups,
    ) {
        let mut means = Constants::<BLOCK>::new(means, P);
        let mut edges = [Lane::ZERO; P];
        for block in parts::<BLOCK>(0..batch.samples()) {
            let means = means.at(block.0);
            let own = [self.squares.as_mut_slice(), self.neighbours.as_mut_slice()];
            structured::add_squares(structure, batch, block, means, &mut edges, own);
        }
    }
}

/// What the residuals of `theta` come to, one lane per parameter. `kept` is ζ, where it was kept. `intercepts`: three per run and
/// group.
pub(crate) fn residuals(batch: AnyBatch, kept: &Kept, theta: &[Lane], intercepts: Groups) -> Lags {
    let mut lags = Lags::ZERO;
    match batch.model().structure() {
        Some(known) => over_batch!(batch, |batch| add_known(known, &batch, theta, intercepts, &mut lags)),
        None => over_batch!(batch, |batch| {
            spans::add_residuals(&batch, kept, theta, intercepts, &mut lags);
        }),
    }
    lags
}

#[inline(always)]
fn add_known<X: Number, const V: usize, const P: usize>(
    structure: impl Structure<V, P>,
    batch: &Batch<X>,
    theta: &[Lane],
    intercepts: Groups,
    lags: &mut Lags,
) {
    let mut intercepts = Constants::<BLOCK>::new(intercepts, 3);
    let mut edges = [Lane::ZERO; 3];
    for block in parts::<BLOCK>(0..batch.samples()) {
        let intercepts = intercepts.at(block.0);
        let mut residuals = [[Lane::ZERO; BLOCK]; 3];
        structured::residuals(structure, batch, block, theta, intercepts, &mut residuals);
        for (d, own) in residuals.iter().enumerate() {
            lags.add(
                d,
                #[inline(always)]
                |t| own[t],
                &mut edges[d],
            );
        }
    }
}
