//! The covariance of the residuals' part in an estimate.
//!
//! θ̂ − θ = A⁻¹ Σ ζᶜ(k) ε(k). The residual contains e(k+1) − e(k), so it is correlated with its neighbours: it is taken as
//! a moving average of order one with autocovariances γ₀, γ₁, and |γ₁| ≤ γ₀/2 as every such process has.

use vessel::{LANES, Lane, Model, Number};

use crate::batch::{AnyBatch, BLOCK, Block, Regressors, SPAN, Signals, over_batch};
use crate::{Batch, structured};

/// A group of samples that shares its intercepts: its first sample, and a constant per signal.
#[derive(Clone, Debug)]
pub(crate) struct Group {
    pub start: usize,
    pub constants: Vec<f64>,
}

/// Per degree of freedom Σ ζᶜζᶜᵀ and Σ (ζᶜ(k−1) ζᶜ(k)ᵀ + its transpose), upper triangles.
pub(crate) struct InstrumentSquares {
    pub squares: Vec<Lane>,
    pub neighbours: Vec<Lane>,
}

impl InstrumentSquares {
    /// `means`: the instruments' means per run and group.
    pub(crate) fn over(batch: AnyBatch, means: [&[Group]; LANES]) -> Self {
        over_batch!(batch, |batch| Self::of(&batch, means))
    }

    #[inline(always)]
    fn of<X: Number>(batch: &Batch<X>, means: [&[Group]; LANES]) -> Self {
        let triangles = batch.model.degrees.iter().map(|d| d.terms.len() * (d.terms.len() + 1) / 2).sum();
        let zeros = || vec![Lane::ZERO; triangles];
        let mut sums = Self { squares: zeros(), neighbours: zeros() };
        let mut means = Constants::new(means, batch.model.parameters());
        if let Some(structure) = batch.model.structure() {
            let mut edges = vec![Lane::ZERO; batch.model.parameters()];
            for k in (0..batch.samples()).step_by(BLOCK) {
                let (block, means) = ((k, BLOCK.min(batch.samples() - k)), means.at(k));
                let own = [sums.squares.as_mut_slice(), sums.neighbours.as_mut_slice()];
                structured::add_squares(structure, batch, block, means, &mut edges, own);
            }
            return sums;
        }
        let mut zeta = Regressors::new(batch.model);
        let mut centred = vec![[Lane::ZERO; 1 + BLOCK]; batch.model.parameters()];
        for k in (0..batch.samples()).step_by(SPAN) {
            let count = SPAN.min(batch.samples() - k);
            batch.zeta(k, count, &mut zeta);
            let terms = zeta.terms(0..centred.len());
            for block in (0..count).step_by(BLOCK) {
                let means = means.at(k + block);
                for (i, (own, mean)) in centred.iter_mut().zip(means).enumerate() {
                    let z = terms.signal(i);
                    own[0] = own[BLOCK];
                    for t in 0..BLOCK {
                        own[1 + t] = z[block + t].lane() - mean[t];
                    }
                    own[1 + BLOCK.min(count - block)..].fill(Lane::ZERO);
                }
                sums.add_block(batch.model, &centred);
            }
        }
        sums
    }

    /// Adds a block of centred instruments, which begin with the sample before.
    #[inline(always)]
    fn add_block(&mut self, model: &Model, centred: &[[Lane; 1 + BLOCK]]) {
        let (mut first, mut place) = (0, 0);
        for p in model.degrees.iter().map(|d| d.terms.len()) {
            for i in first..first + p {
                for others in centred[i..first + p].chunks(2) {
                    match others {
                        [one, two] => self.add(place, &centred[i], [one, two]),
                        _ => self.add(place, &centred[i], [&others[0]]),
                    }
                    place += others.len();
                }
            }
            first += p;
        }
    }

    /// Adds products of one block with some others, those with itself and with its neighbours, from `place` on. Blocks
    /// begin with the sample before.
    #[inline(always)]
    fn add<const C: usize>(
        &mut self,
        place: usize,
        one: &[Lane; 1 + BLOCK],
        others: [&[Lane; 1 + BLOCK]; C],
    ) {
        let mut own = [[Lane::ZERO; 3]; C];
        for t in 0..BLOCK {
            for ([now, after, before], other) in own.iter_mut().zip(others) {
                *now = one[t + 1].fused(other[t + 1], *now);
                *after = one[t].fused(other[t + 1], *after);
                *before = one[t + 1].fused(other[t], *before);
            }
        }
        for (i, [now, after, before]) in own.into_iter().enumerate() {
            self.squares[place + i] += now;
            self.neighbours[place + i] += after;
            self.neighbours[place + i] += before;
        }
    }
}

/// Per degree of freedom γ₀ N and γ₁ N.
pub(crate) struct ResidualSums {
    pub lag0: [Lane; 3],
    pub lag1: [Lane; 3],
}

impl ResidualSums {
    /// `theta`: one lane per parameter. `intercepts`: three per run and group.
    pub(crate) fn over(batch: AnyBatch, theta: &[Lane], intercepts: [&[Group]; LANES]) -> Self {
        over_batch!(batch, |batch| Self::of(&batch, theta, intercepts))
    }

    #[inline(always)]
    fn of<X: Number>(batch: &Batch<X>, theta: &[Lane], intercepts: [&[Group]; LANES]) -> Self {
        let mut sums = Self { lag0: [Lane::ZERO; 3], lag1: [Lane::ZERO; 3] };
        let mut intercepts = Constants::new(intercepts, 3);
        let mut edges = [Lane::ZERO; 3];
        if let Some(structure) = batch.model.structure() {
            for k in (0..batch.samples()).step_by(BLOCK) {
                let (block, intercepts) = ((k, BLOCK.min(batch.samples() - k)), intercepts.at(k));
                let mut residuals = [[Lane::ZERO; BLOCK]; 3];
                structured::residuals(structure, batch, block, theta, intercepts, &mut residuals);
                for (d, residuals) in residuals.iter().enumerate() {
                    sums.add(d, residuals, &mut edges[d]);
                }
            }
            return sums;
        }
        let mut phi = Regressors::new(batch.model);
        for k in (0..batch.samples()).step_by(SPAN) {
            let count = SPAN.min(batch.samples() - k);
            batch.phi(k, count, &mut phi);
            let mut increments = [[Lane::ZERO; SPAN]; 3];
            for (d, own) in increments.iter_mut().enumerate() {
                batch.increments(k, count, d, &phi, own);
            }
            for block in (0..count).step_by(BLOCK) {
                let intercepts = intercepts.at(k + block);
                let within = BLOCK.min(count - block);
                let mut first = 0;
                for d in 0..3 {
                    let mut residual = [Lane::ZERO; BLOCK];
                    for t in 0..BLOCK {
                        residual[t] = increments[d][block + t] - intercepts[d][t];
                    }
                    residual[within..].fill(Lane::ZERO);
                    let own = first..first + batch.model.degrees[d].terms.len();
                    let terms = phi.terms(own.clone());
                    subtract(&mut residual, terms, &theta[own.clone()], block);
                    first = own.end;
                    sums.add(d, &residual, &mut edges[d]);
                }
            }
        }
        sums
    }

    /// Adds the products of a block of residuals with themselves and their neighbours; `edge` came before it.
    #[inline(always)]
    fn add(&mut self, d: usize, residual: &Block<Lane>, edge: &mut Lane) {
        let (mut lag0, mut lag1) = (Lane::ZERO, Lane::ZERO);
        for now in residual {
            lag0 = now.fused(*now, lag0);
            lag1 = edge.fused(*now, lag1);
            *edge = *now;
        }
        self.lag0[d] += lag0;
        self.lag1[d] += lag1;
    }
}

/// Subtracts the terms with their parameters, in the block that begins at sample `block` of theirs.
#[inline(always)]
fn subtract(residual: &mut Block<Lane>, terms: impl Signals<Lane, SPAN>, theta: &[Lane], block: usize) {
    let mut own = *residual;
    for (i, theta) in theta.iter().enumerate() {
        let less = Lane::ZERO - *theta;
        let Some(term) = terms.signal(i)[block..].first_chunk::<BLOCK>() else { break };
        for t in 0..BLOCK {
            own[t] = term[t].fused(less, own[t]);
        }
    }
    *residual = own;
}

/// The groups' constants that hold at each sample of a block, lane by lane.
struct Constants<'a> {
    groups: [&'a [Group]; LANES],
    signals: Vec<Block<Lane>>,
    next: [usize; LANES],
    /// The block with this sample is the next that differs from the one before it.
    changes: usize,
}

impl<'a> Constants<'a> {
    fn new(groups: [&'a [Group]; LANES], signals: usize) -> Self {
        Self { groups, signals: vec![[Lane::ZERO; BLOCK]; signals], next: [0; LANES], changes: 0 }
    }

    /// The constants of the block that starts at sample `k`; blocks are asked for one after the other.
    fn at(&mut self, k: usize) -> &[Block<Lane>] {
        if self.changes < k + BLOCK {
            self.changes = usize::MAX;
            (0..LANES).for_each(|lane| self.enter(k, lane));
        }
        &self.signals
    }

    fn enter(&mut self, k: usize, lane: usize) {
        let groups = self.groups[lane];
        // A group that began inside the last block holds for all of this one.
        if let Some(i) = self.next[lane].checked_sub(1) {
            self.hold(lane, 0, &groups[i]);
        }
        while let Some(group) = groups.get(self.next[lane]).filter(|g| g.start < k + BLOCK) {
            self.hold(lane, group.start - k, group);
            self.next[lane] += 1;
            if group.start > k {
                self.changes = self.changes.min(k + BLOCK);
            }
        }
        if let Some(group) = groups.get(self.next[lane]) {
            self.changes = self.changes.min(group.start);
        }
    }

    /// Lets `group` hold for `lane` from sample `from` of the block on.
    fn hold(&mut self, lane: usize, from: usize, group: &Group) {
        for (signal, value) in self.signals.iter_mut().zip(&group.constants) {
            signal[from..].iter_mut().for_each(|at| at[lane] = *value);
        }
    }
}
