//! The covariance of the residuals' part in an estimate.
//!
//! θ̂ − θ = A⁻¹ Σ ζᶜ(k) ε(k). The residual contains e(k+1) − e(k), so it is correlated with its neighbours: it is taken as
//! a moving average of order one with autocovariances γ₀, γ₁, and |γ₁| ≤ γ₀/2 as every such process has.

use vessel::{LANES, Lane};

use crate::Batch;
use crate::batch::{BLOCK, Block, Regressors, dot};

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
        let (parameters, triangles) = (batch.model.parameters(), sizes.iter().map(|p| p * (p + 1) / 2).sum());
        let mut sums = ResidualSums {
            lag0: [Lane::ZERO; 3],
            lag1: [Lane::ZERO; 3],
            squares: vec![Lane::ZERO; triangles],
            neighbours: vec![Lane::ZERO; triangles],
        };
        let mut current = Current::new(parameters);
        let (mut phi, mut zeta) = (Regressors::new(batch.model), Regressors::new(batch.model));
        let mut before = vec![[Lane::ZERO; BLOCK]; parameters];
        let mut residuals = [[Lane::ZERO; BLOCK]; 3];
        let mut k = 0;
        while k < batch.samples() {
            let count = BLOCK.min(batch.samples() - k);
            batch.regressors(batch.measured, k, count, &mut phi);
            let last = |block: &Block| block[BLOCK - 1];
            let edges: Vec<Lane> = zeta.terms.iter().map(last).collect();
            batch.regressors(batch.instrument_states, k, count, &mut zeta);
            let mut constants = [[Lane::ZERO; BLOCK]; 3];
            for t in 0..count {
                current.enter(k + t, fitted);
                zeta.terms.iter_mut().zip(&current.means).for_each(|(z, mean)| z[t] = z[t] - *mean);
                constants.iter_mut().zip(current.intercepts).for_each(|(c, intercept)| c[t] = intercept);
            }
            for (own, (z, edge)) in before.iter_mut().zip(zeta.terms.iter().zip(edges)) {
                *own = delayed(z, edge);
            }
            let (mut first, mut place) = (0, 0);
            for (d, p) in sizes.iter().copied().enumerate() {
                let edge = last(&residuals[d]);
                let own = &mut residuals[d];
                *own = batch.increments(k, count, d);
                own.iter_mut().zip(constants[d]).for_each(|(e, c)| *e = *e - c);
                for (f, theta) in phi.terms[first..first + p].iter().zip(&fitted.theta[first..first + p]) {
                    own.iter_mut().zip(f).for_each(|(e, f)| *e = *e - *f * *theta);
                }
                sums.lag0[d] += dot(own, own);
                sums.lag1[d] += dot(own, &delayed(own, edge));
                for i in first..first + p {
                    for j in i..first + p {
                        sums.squares[place] += dot(&zeta.terms[i], &zeta.terms[j]);
                        sums.neighbours[place] +=
                            dot(&before[i], &zeta.terms[j]) + dot(&before[j], &zeta.terms[i]);
                        place += 1;
                    }
                }
                first += p;
            }
            k += count;
        }
        sums
    }
}

/// The signal one sample earlier; `edge` comes before it.
#[inline(always)]
fn delayed(signal: &Block, edge: Lane) -> Block {
    std::array::from_fn(|t| if t == 0 { edge } else { signal[t - 1] })
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
