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
        let mut edges = vec![Lane::ZERO; parameters];
        let mut residuals = [[Lane::ZERO; BLOCK]; 3];
        for k in (0..batch.samples()).step_by(BLOCK) {
            let count = BLOCK.min(batch.samples() - k);
            current.enter(k, fitted);
            batch.regressors(batch.measured, k, count, &mut phi);
            for (edge, z) in edges.iter_mut().zip(&zeta.terms) {
                *edge = z[BLOCK - 1];
            }
            batch.regressors(batch.instrument_states, k, count, &mut zeta);
            for (z, means) in zeta.terms.iter_mut().zip(&current.means) {
                subtract(z, means, count);
            }
            for (own, (z, edge)) in before.iter_mut().zip(zeta.terms.iter().zip(&edges)) {
                *own = delayed(z, *edge);
            }
            let (mut first, mut place) = (0, 0);
            for (d, p) in sizes.iter().copied().enumerate() {
                let edge = residuals[d][BLOCK - 1];
                let own = &mut residuals[d];
                *own = batch.increments(k, count, d);
                subtract(own, &current.intercepts[d], count);
                for (f, theta) in phi.terms[first..first + p].iter().zip(&fitted.theta[first..first + p]) {
                    for (e, f) in own.iter_mut().zip(f) {
                        *e = *e - *f * *theta;
                    }
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
        }
        sums
    }
}

/// Subtracts the first `count` constants; beyond, the signal stays zero.
#[inline(always)]
fn subtract(signal: &mut Block, constants: &Block, count: usize) {
    for t in 0..BLOCK {
        signal[t] = signal[t] - constants[t];
    }
    signal[count..].fill(Lane::ZERO);
}

/// The signal one sample earlier; `edge` comes before it.
#[inline(always)]
fn delayed(signal: &Block, edge: Lane) -> Block {
    let mut out = [edge; BLOCK];
    out[1..].copy_from_slice(&signal[..BLOCK - 1]);
    out
}

/// The intercepts and instrument means that hold at each sample of a block, lane by lane.
struct Current {
    intercepts: [Block; 3],
    means: Vec<Block>,
    next: [usize; LANES],
}

impl Current {
    fn new(parameters: usize) -> Self {
        let zero = [Lane::ZERO; BLOCK];
        Self { intercepts: [zero; 3], means: vec![zero; parameters], next: [0; LANES] }
    }

    /// Moves on to the block that starts at sample `k`.
    fn enter(&mut self, k: usize, fitted: &Fitted) {
        for lane in 0..LANES {
            // A group that began inside the last block holds for all of this one.
            let begun = self.next[lane].checked_sub(1).map(|i| &fitted.groups[lane][i]);
            if let Some(group) = begun.filter(|g| g.start < k && k < g.start + BLOCK) {
                self.hold(lane, 0, group);
            }
            while let Some(group) = fitted.groups[lane].get(self.next[lane]).filter(|g| g.start < k + BLOCK) {
                self.hold(lane, group.start - k, group);
                self.next[lane] += 1;
            }
        }
    }

    /// Lets `group` hold for `lane` from sample `from` of the block on.
    fn hold(&mut self, lane: usize, from: usize, group: &Group) {
        let signals = self.intercepts.iter_mut().chain(&mut self.means);
        for (signal, value) in signals.zip(group.intercepts.iter().chain(&group.means)) {
            signal[from..].iter_mut().for_each(|at| at[lane] = *value);
        }
    }
}
