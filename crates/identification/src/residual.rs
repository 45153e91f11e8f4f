//! The covariance of the residuals' part in an estimate.
//!
//! θ̂ − θ = A⁻¹ Σ ζᶜ(k) ε(k). The residual contains e(k+1) − e(k), so it is correlated with its neighbours: it is taken as
//! a moving average of order one with autocovariances γ₀, γ₁, and |γ₁| ≤ γ₀/2 as every such process has.

use vessel::{LANES, Lane};

use crate::Batch;
use crate::batch::regressors;

/// What the residual pass needs to know of every run: lanes per parameter, per degree of freedom, and per segment.
pub(crate) struct Fitted<'a> {
    /// θ̂, one lane per parameter.
    pub theta: &'a [Lane],
    /// Per run and group: first sample, intercepts (3) and instrument means (one per parameter).
    pub groups: [&'a [Group]; LANES],
}

/// A group of samples that shares its intercepts.
#[derive(Clone, Debug, Default)]
pub(crate) struct Group {
    pub start: usize,
    pub intercepts: [f64; 3],
    pub means: Vec<f64>,
}

/// Per degree of freedom: γ₀ N and γ₁ N, Σ ζᶜζᶜᵀ and Σ (ζᶜ(k−1) ζᶜ(k)ᵀ + its transpose), upper triangles.
pub(crate) struct ResidualSums {
    pub lag0: [Lane; 3],
    pub lag1: [Lane; 3],
    pub squares: Vec<Lane>,
    pub neighbours: Vec<Lane>,
}

impl ResidualSums {
    pub(crate) fn over(batch: &Batch, fitted: &Fitted) -> Self {
        pulp::Arch::new().dispatch(Pass { batch, fitted })
    }
}

/// One pass over the data; compiled for every instruction set that pulp picks from.
struct Pass<'a> {
    batch: &'a Batch<'a>,
    fitted: &'a Fitted<'a>,
}

impl pulp::WithSimd for Pass<'_> {
    type Output = ResidualSums;

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) -> ResidualSums {
        let Self { batch, fitted } = self;
        let sizes: Vec<usize> = batch.model.degrees.iter().map(|d| d.terms.len()).collect();
        let (total, triangles) = (batch.model.parameters(), sizes.iter().map(|p| p * (p + 1) / 2).sum());
        let mut sums = ResidualSums {
            lag0: [Lane::ZERO; 3],
            lag1: [Lane::ZERO; 3],
            squares: vec![Lane::ZERO; triangles],
            neighbours: vec![Lane::ZERO; triangles],
        };
        let mut current = Current::new(total);
        let (mut phi, mut zeta, mut before) =
            (vec![Lane::ZERO; total], vec![Lane::ZERO; total], vec![Lane::ZERO; total]);
        let mut values = vec![Lane::ZERO; batch.model.variables.len()];
        let mut previous = [Lane::ZERO; 3];
        for k in 0..batch.samples() {
            current.enter(k, fitted);
            batch.variables(batch.measured, k, &mut values);
            regressors(batch.model, &values, &mut phi);
            batch.variables(batch.instrument_states, k, &mut values);
            std::mem::swap(&mut zeta, &mut before);
            regressors(batch.model, &values, &mut zeta);
            zeta.iter_mut().zip(&current.means).for_each(|(z, mean)| *z = *z - *mean);
            let (mut first, mut place) = (0, 0);
            for (d, p) in sizes.iter().copied().enumerate() {
                let mut residual = batch.increment(k, d) - current.intercepts[d];
                for (f, t) in phi[first..first + p].iter().zip(&fitted.theta[first..first + p]) {
                    residual = residual - *f * *t;
                }
                sums.lag0[d] += residual * residual;
                sums.lag1[d] += residual * previous[d];
                previous[d] = residual;
                for i in first..first + p {
                    for j in i..first + p {
                        sums.squares[place] += zeta[i] * zeta[j];
                        sums.neighbours[place] += before[i] * zeta[j] + before[j] * zeta[i];
                        place += 1;
                    }
                }
                first += p;
            }
        }
        sums
    }
}

/// The intercepts and instrument means that hold at the current sample, lane by lane.
struct Current {
    intercepts: [Lane; 3],
    means: Vec<Lane>,
    next: [usize; LANES],
}

impl Current {
    fn new(parameters: usize) -> Self {
        Self { intercepts: [Lane::ZERO; 3], means: vec![Lane::ZERO; parameters], next: [0; LANES] }
    }

    #[inline(always)]
    fn enter(&mut self, k: usize, fitted: &Fitted) {
        for lane in 0..LANES {
            if let Some(group) = fitted.groups[lane].get(self.next[lane]).filter(|g| g.start == k) {
                self.next[lane] += 1;
                self.intercepts.iter_mut().zip(group.intercepts).for_each(|(c, value)| c[lane] = value);
                self.means.iter_mut().zip(&group.means).for_each(|(m, value)| m[lane] = *value);
            }
        }
    }
}
