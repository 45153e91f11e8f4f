//! The covariance of the residuals' part in an estimate.
//!
//! θ̂ − θ = A⁻¹ Σ ζᶜ(k) ε(k). The residual contains e(k+1) − e(k), so it is correlated with its neighbours: it is taken as
//! a moving average of order one with autocovariances γ₀, γ₁, and |γ₁| ≤ γ₀/2 as every such process has.

use vessel::{LANES, Lane, Model, Number, Structure, vectorized};

use crate::batch::{
    AnyBatch, BLOCK, Block, Kept, Picked, Regressors, SPAN, Signals, Span, Zeta, over_batch, some_of,
};
use crate::sums::measured;
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
        let model = batch.model();
        let triangles = model.degrees.iter().map(|d| d.terms.len() * (d.terms.len() + 1) / 2).sum();
        let zeros = || vec![Lane::ZERO; triangles];
        let mut sums = Self { squares: zeros(), neighbours: zeros() };
        match model.structure() {
            Some(known) => over_batch!(batch, |batch| sums.add_known(known, &batch, means)),
            None => over_batch!(batch, |batch| sums.add_any(&batch, means)),
        }
        sums
    }

    #[inline(always)]
    fn add_known<X: Number, const V: usize, const P: usize>(
        &mut self,
        structure: impl Structure<V, P>,
        batch: &Batch<X>,
        means: [&[Group]; LANES],
    ) {
        let mut means = Constants::<BLOCK>::new(means, P);
        let mut edges = [Lane::ZERO; P];
        for k in (0..batch.samples()).step_by(BLOCK) {
            let (block, means) = ((k, BLOCK.min(batch.samples() - k)), means.at(k));
            let own = [self.squares.as_mut_slice(), self.neighbours.as_mut_slice()];
            structured::add_squares(structure, batch, block, means, &mut edges, own);
        }
    }

    #[inline(always)]
    fn add_any<X: Number>(&mut self, batch: &Batch<X>, means: [&[Group]; LANES]) {
        let mut means = Constants::<BLOCK>::new(means, batch.model.parameters());
        let mut zeta = Regressors::new(batch.model);
        let mut centred = vec![[Lane::ZERO; 1 + BLOCK]; batch.model.parameters()];
        for k in (0..batch.samples()).step_by(SPAN) {
            let count = SPAN.min(batch.samples() - k);
            batch.zeta(k, count, &mut zeta);
            let terms = zeta.terms();
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
                self.add_block(batch.model, &centred);
            }
        }
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
    /// `theta`: one lane per parameter. `intercepts`: three per run and group. `kept` is ζ, where it was kept.
    pub(crate) fn over(
        batch: AnyBatch,
        theta: &[Lane],
        intercepts: [&[Group]; LANES],
        kept: Option<&Kept<f64>>,
    ) -> Self {
        let mut sums = Self { lag0: [Lane::ZERO; 3], lag1: [Lane::ZERO; 3] };
        if let Some(known) = batch.model().structure() {
            over_batch!(batch, |batch| sums.add_known(known, &batch, theta, intercepts));
            return sums;
        }
        match batch {
            AnyBatch::Lanes(batch) => vectorized!(sums.add_any(&batch, theta, intercepts, None)),
            AnyBatch::Shared(batch) => vectorized!(sums.add_any(&batch, theta, intercepts, kept)),
        }
        sums
    }

    #[inline(always)]
    fn add_known<X: Number, const V: usize, const P: usize>(
        &mut self,
        structure: impl Structure<V, P>,
        batch: &Batch<X>,
        theta: &[Lane],
        intercepts: [&[Group]; LANES],
    ) {
        let mut intercepts = Constants::<BLOCK>::new(intercepts, 3);
        let mut edges = [Lane::ZERO; 3];
        for k in (0..batch.samples()).step_by(BLOCK) {
            let (block, intercepts) = ((k, BLOCK.min(batch.samples() - k)), intercepts.at(k));
            let mut residuals = [[Lane::ZERO; BLOCK]; 3];
            structured::residuals(structure, batch, block, theta, intercepts, &mut residuals);
            for (d, residuals) in residuals.iter().enumerate() {
                self.add(d, residuals, &mut edges[d]);
            }
        }
    }

    #[inline(always)]
    fn add_any<X: Number>(
        &mut self,
        batch: &Batch<X>,
        theta: &[Lane],
        intercepts: [&[Group]; LANES],
        kept: Option<&Kept<X>>,
    ) {
        let mut edges = [Lane::ZERO; 3];
        let mut intercepts = Constants::<SPAN>::new(intercepts, 3);
        let measured = measured(batch.model);
        let mut phi = Regressors::of(batch.model, measured.map(|measured| 0..measured));
        let mut inputs = Zeta::new(kept, 0, batch.model, measured.map(|measured| measured..usize::MAX));
        let mut left = [Lane::ZERO; SPAN];
        for k in (0..batch.samples()).step_by(SPAN) {
            let count = SPAN.min(batch.samples() - k);
            batch.phi(k, count, &mut phi);
            let inputs = inputs.at(batch, k, count);
            let intercepts = intercepts.at(k);
            let mut first = 0;
            for d in 0..3 {
                let own = first..first + batch.model.degrees[d].terms.len();
                first = own.end;
                let middle = own.start + measured[d];
                let terms = Terms {
                    measured: phi.terms().part(own.start..middle),
                    inputs: inputs.part(middle..own.end),
                    theta: &theta[own],
                };
                let (intercepts, edge) = (&intercepts[d], &mut edges[d]);
                match batch.between(k, count, d).filter(|_| terms.at_once()) {
                    Some(rows) => self.subtract(
                        d,
                        #[inline(always)]
                        |t| rows[t + 1][d] - rows[t][d] - intercepts[t],
                        terms,
                        edge,
                    ),
                    None => {
                        batch.increments(k, count, d, &phi, &mut left);
                        for (left, intercept) in left[..count].iter_mut().zip(intercepts) {
                            *left = *left - *intercept;
                        }
                        let terms = if terms.at_once() { terms } else { terms.subtract_all(&mut left) };
                        self.subtract(
                            d,
                            #[inline(always)]
                            |t| left[t],
                            terms,
                            edge,
                        );
                    }
                }
            }
        }
    }

    /// Adds what [`Self::add`] does, of the residuals of a span: `y` less terms that are few enough.
    #[inline(always)]
    fn subtract<X: Number>(&mut self, d: usize, y: impl Fn(usize) -> Lane, terms: Terms<X>, edge: &mut Lane) {
        match (terms.measured.count(), terms.inputs.count()) {
            (1, 0) => self.add_span::<X, 1, 0>(d, y, terms, edge),
            (1, _) => self.add_span::<X, 1, 1>(d, y, terms, edge),
            (2, 0) => self.add_span::<X, 2, 0>(d, y, terms, edge),
            (2, _) => self.add_span::<X, 2, 1>(d, y, terms, edge),
            (3, 0) => self.add_span::<X, 3, 0>(d, y, terms, edge),
            (3, _) => self.add_span::<X, 3, 1>(d, y, terms, edge),
            (AT_ONCE, 0) => self.add_span::<X, AT_ONCE, 0>(d, y, terms, edge),
            (AT_ONCE, _) => self.add_span::<X, AT_ONCE, 1>(d, y, terms, edge),
            (_, 0) => self.add_span::<X, 0, 0>(d, y, terms, edge),
            (_, _) => self.add_span::<X, 0, 1>(d, y, terms, edge),
        }
    }

    /// [`Self::subtract`] of `C` terms and `I` of inputs alone.
    #[inline(always)]
    fn add_span<X: Number, const C: usize, const I: usize>(
        &mut self,
        d: usize,
        y: impl Fn(usize) -> Lane,
        terms: Terms<X>,
        edge: &mut Lane,
    ) {
        let (measured, inputs): ([_; C], [_; I]) = (some_of(&terms.measured, 0), some_of(&terms.inputs, 0));
        let (first, last) = (less::<C>(terms.theta), less::<I>(&terms.theta[C..]));
        let mut before = *edge;
        for block in (0..SPAN).step_by(BLOCK) {
            let (mut lag0, mut lag1) = (Lane::ZERO, Lane::ZERO);
            for t in block..block + BLOCK {
                let now = remaining(remaining(y(t), &measured, &first, t), &inputs, &last, t);
                lag0 = now.fused(now, lag0);
                lag1 = before.fused(now, lag1);
                before = now;
            }
            self.lag0[d] += lag0;
            self.lag1[d] += lag1;
        }
        *edge = before;
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

/// The terms of a degree of freedom in a span: those with measured states in them, then those of inputs alone.
#[derive(Clone, Copy)]
struct Terms<'a, X> {
    measured: Picked<'a, Lane>,
    inputs: Picked<'a, X>,
    /// Parameters of all.
    theta: &'a [Lane],
}

/// Terms with measured states that are subtracted at once: their parameters have a register each.
const AT_ONCE: usize = 4;

impl<X: Number> Terms<'_, X> {
    /// Whether all can be subtracted at once.
    #[inline(always)]
    fn at_once(&self) -> bool {
        self.measured.count() <= AT_ONCE && self.inputs.count() <= 1
    }

    /// Subtracts all with their parameters; what is left of them.
    #[inline(always)]
    fn subtract_all(self, left: &mut Span<Lane>) -> Self {
        let (of_measured, of_inputs) = self.theta.split_at(self.measured.count());
        subtract_each(left, self.measured, of_measured);
        subtract_each(left, self.inputs, of_inputs);
        Self { measured: self.measured.part(0..0), inputs: self.inputs.part(0..0), theta: &[] }
    }
}

/// Subtracts terms with their parameters, some at a time.
#[inline(always)]
fn subtract_each<X: Number>(left: &mut Span<Lane>, terms: Picked<X>, theta: &[Lane]) {
    let whole = theta.len() - theta.len() % AT_ONCE;
    for i in (0..whole).step_by(AT_ONCE) {
        subtract_some::<X, AT_ONCE>(left, some_of(&terms, i), &theta[i..]);
    }
    for i in whole..theta.len() {
        subtract_some::<X, 1>(left, some_of(&terms, i), &theta[i..]);
    }
}

#[inline(always)]
fn subtract_some<X: Number, const C: usize>(left: &mut Span<Lane>, terms: [&Span<X>; C], theta: &[Lane]) {
    let less = less(theta);
    for (t, left) in left.iter_mut().enumerate() {
        *left = remaining(*left, &terms, &less, t);
    }
}

/// The first `C` parameters, below zero.
#[inline(always)]
fn less<const C: usize>(theta: &[Lane]) -> [Lane; C] {
    let mut less = [Lane::ZERO; C];
    for (less, theta) in less.iter_mut().zip(theta) {
        *less = *less - *theta;
    }
    less
}

/// A residual at sample `t` less some terms.
#[inline(always)]
fn remaining<X: Number, const C: usize>(
    mut residual: Lane,
    terms: &[&Span<X>; C],
    less: &[Lane; C],
    t: usize,
) -> Lane {
    for i in 0..C {
        residual = terms[i][t].lane().fused(less[i], residual);
    }
    residual
}

/// The groups' constants that hold at each of `N` samples, lane by lane.
struct Constants<'a, const N: usize> {
    groups: [&'a [Group]; LANES],
    signals: Vec<[Lane; N]>,
    next: [usize; LANES],
    /// The samples with this one among them are the next that differ from those before.
    changes: usize,
}

impl<'a, const N: usize> Constants<'a, N> {
    fn new(groups: [&'a [Group]; LANES], signals: usize) -> Self {
        Self { groups, signals: vec![[Lane::ZERO; N]; signals], next: [0; LANES], changes: 0 }
    }

    /// The constants of the samples from `k` on; they are asked for one after the other.
    fn at(&mut self, k: usize) -> &[[Lane; N]] {
        if self.changes < k + N {
            self.changes = usize::MAX;
            (0..LANES).for_each(|lane| self.enter(k, lane));
        }
        &self.signals
    }

    fn enter(&mut self, k: usize, lane: usize) {
        let groups = self.groups[lane];
        // A group that began among the last samples holds for all of these.
        if let Some(i) = self.next[lane].checked_sub(1) {
            self.hold(lane, 0, &groups[i]);
        }
        while let Some(group) = groups.get(self.next[lane]).filter(|g| g.start < k + N) {
            self.hold(lane, group.start - k, group);
            self.next[lane] += 1;
            if group.start > k {
                self.changes = self.changes.min(k + N);
            }
        }
        if let Some(group) = groups.get(self.next[lane]) {
            self.changes = self.changes.min(group.start);
        }
    }

    /// Lets `group` hold for `lane` from sample `from` of these on.
    fn hold(&mut self, lane: usize, from: usize, group: &Group) {
        for (signal, value) in self.signals.iter_mut().zip(&group.constants) {
            signal[from..].iter_mut().for_each(|at| at[lane] = *value);
        }
    }
}
