//! Products of centred instruments with each other and with their neighbours.

use numerics::Lane;
use numerics::lanes::{self, BLOCK, Block, add, part, parts, put};
use pulp::{Simd, WithSimd};

use super::columns::{Instrument, Kept, Zeta};
use super::regressors::{ALL, Order, Regressors, Table, fill};
use super::{Blocks, Column, Difference, SPAN, Signal, Signals, spans};
use crate::Batch;
use crate::sums::{Constants, Groups};

/// Instruments of a degree of freedom that are multiplied with each other at once.
const AT_ONCE: usize = 4;
/// Means at the samples of a block.
type Means = Block<Lane>;

/// Adds to Σ ζᶜζᶜᵀ and to Σ (ζᶜ(k−1) ζᶜ(k)ᵀ + its transpose), upper triangles of all degrees of freedom. `means`: the instruments'
/// means per run and group.
#[inline(always)]
pub(crate) fn add_squares<X: Instrument>(
    batch: &Batch<X>,
    kept: &Kept,
    means: Groups,
    [squares, neighbours]: [&mut [Lane]; 2],
) {
    let mut means = Constants::<BLOCK>::new(means, batch.model.parameters());
    let mut zeta = X::zeta(batch, kept, ALL);
    let mut edges = vec![Lane::ZERO; batch.model.parameters()];
    let orders = Order::of(batch.model);
    let mut sums = orders.each_ref().map(|Order { terms, .. }| {
        let entries = terms.len() * (terms.len() + 1) / 2;
        [vec![Lane::ZERO; entries], vec![Lane::ZERO; entries]]
    });
    for (k, count) in spans(0..batch.samples()) {
        zeta.go_to(k, count);
        let mut at = k;
        while at < k + count {
            let (end, means) = means.over(at..k + count);
            let blocks = Blocks::of(at - k..end - k);
            let mut first = 0;
            for (d, sum) in sums.iter_mut().enumerate() {
                let (terms, order) = (zeta.terms(d), orders[d].terms.as_slice());
                let range = first..first + order.len();
                first = range.end;
                let centred = Centred { terms, order, means: &means[range.clone()], blocks };
                centred.add(&mut edges[range], sum.each_mut().map(Vec::as_mut_slice));
            }
            at = end;
        }
    }
    let mut first = 0;
    for (Order { terms, .. }, sum) in orders.iter().zip(&sums) {
        let p = terms.len();
        for (i, j) in (0..p).flat_map(|i| (i..p).map(move |j| (i, j))) {
            let (row, column) = (terms[i].min(terms[j]), terms[i].max(terms[j]));
            let to = first + place(p, row, column);
            squares[to] = sum[0][place(p, i, j)];
            neighbours[to] = sum[1][place(p, i, j)];
        }
        first += p * (p + 1) / 2;
    }
}

/// The index of entry (i, j) of the upper triangle of a p × p matrix.
fn place(p: usize, i: usize, j: usize) -> usize {
    i * p + j - i * (i + 1) / 2
}

/// Blocks of a degree of freedom's instruments less their means, the same in each block.
#[derive(Clone, Copy)]
struct Centred<'a, T> {
    terms: T,
    /// Per term its index among the means.
    order: &'a [usize],
    means: &'a [Means],
    blocks: Blocks,
}

impl<'a, T: Signals> Centred<'a, T> {
    /// Adds all products. `edges` are the values at the sample before; they become the last.
    fn add(self, edges: &mut [Lane], mut sums: [&mut [Lane]; 2]) {
        let p = edges.len();
        for first in (0..p).step_by(AT_ONCE) {
            for row in 0..first {
                let sums = sums.each_mut().map(|sums| &mut sums[place(p, row, first)..]);
                match p - first {
                    1 => self.add_row::<1>(row, first, edges, sums),
                    2 => self.add_row::<2>(row, first, edges, sums),
                    3 => self.add_row::<3>(row, first, edges, sums),
                    _ => self.add_row::<AT_ONCE>(row, first, edges, sums),
                }
            }
        }
        for first in (0..p).step_by(AT_ONCE) {
            let sums = sums.each_mut().map(|sums| &mut sums[place(p, first, first)..]);
            match p - first {
                1 => self.add_triangle::<1>(first, edges, sums),
                2 => self.add_triangle::<2>(first, edges, sums),
                3 => self.add_triangle::<3>(first, edges, sums),
                _ => self.add_triangle::<AT_ONCE>(first, edges, sums),
            }
        }
    }

    /// Adds the products of `N` instruments from `first` on with each other.
    fn add_triangle<const N: usize>(self, first: usize, edges: &mut [Lane], sums: [&mut [Lane]; 2]) {
        let width = edges.len() - first;
        let all = self.some::<N>(first, edges);
        let edge = numerics::dispatch(Triangle { all, width, sums });
        edges[first..first + N].copy_from_slice(&edge);
    }

    /// Adds the products of instrument `row` with `N` others from `first` on.
    fn add_row<const N: usize>(self, row: usize, first: usize, edges: &[Lane], sums: [&mut [Lane]; 2]) {
        let (one, others) = (self.some::<1>(row, edges), self.some::<N>(first, edges));
        numerics::dispatch(Row { one, others, sums });
    }

    /// `N` instruments from `first` on.
    fn some<const N: usize>(self, first: usize, edges: &[Lane]) -> Some<'a, T::One, N> {
        let mut edge = [Lane::ZERO; N];
        edge.copy_from_slice(&edges[first..first + N]);
        Some {
            terms: self.terms.some(first),
            means: std::array::from_fn(|i| &self.means[self.order[first + i]]),
            edge,
            blocks: self.blocks,
        }
    }
}

/// Some instruments, their means, and their values at the sample before.
struct Some<'a, T, const N: usize> {
    terms: [T; N],
    means: [&'a Means; N],
    edge: [Lane; N],
    blocks: Blocks,
}

impl<T: Signal, const N: usize> Some<'_, T, N> {
    /// Register `part` of them at sample `t` of a block, centred.
    #[allow(clippy::needless_range_loop)] // What iterators make of arrays is not always inlined, and then has no vectors.
    #[inline(always)]
    fn at<S: Simd>(&self, simd: S, block: usize, t: usize, part: usize) -> [S::f64s; N] {
        let mut now = [simd.splat_f64s(0.0); N];
        for i in 0..N {
            let mean = lanes::part::<S>(&self.means[i][t], part);
            now[i] = simd.sub_f64s(self.terms[i].at(simd, block + t, part), mean);
        }
        now
    }

    /// At the sample before.
    #[inline(always)]
    fn before<S: Simd>(&self, simd: S, part: usize) -> [S::f64s; N] {
        let mut before = [simd.splat_f64s(0.0); N];
        for (before, edge) in before.iter_mut().zip(&self.edge) {
            *before = lanes::part::<S>(edge, part);
        }
        before
    }
}

/// Instruments that are multiplied with each other. The first row of sums has `width` entries, each other one less than the one
/// before.
struct Triangle<'a, T, const N: usize> {
    all: Some<'a, T, N>,
    width: usize,
    sums: [&'a mut [Lane]; 2],
}

impl<T: Signal, const N: usize> WithSimd for Triangle<'_, T, N> {
    /// Those of the last sample.
    type Output = [Lane; N];

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> [Lane; N] {
        let Self { all, width, sums: [squares, neighbours] } = self;
        let zero = simd.splat_f64s(0.0);
        let mut edge = all.edge;
        for at in 0..parts::<S>() {
            let mut before = all.before(simd, at);
            for block in all.blocks.starts() {
                let (mut squared, mut followed) = ([[zero; N]; N], [[zero; N]; N]);
                for t in 0..BLOCK {
                    let now = all.at(simd, block, t, at);
                    for i in 0..N {
                        for j in 0..N {
                            if j >= i {
                                squared[i][j] = simd.mul_add_f64s(now[i], now[j], squared[i][j]);
                            }
                            followed[i][j] = simd.mul_add_f64s(before[i], now[j], followed[i][j]);
                        }
                    }
                    before = now;
                }
                let mut place = 0;
                for i in 0..N {
                    for j in i..N {
                        add(simd, &mut squares[place + j - i], at, squared[i][j]);
                        add(simd, &mut neighbours[place + j - i], at, followed[i][j]);
                        add(simd, &mut neighbours[place + j - i], at, followed[j][i]);
                    }
                    place += width - i;
                }
            }
            for i in 0..N {
                put::<S>(&mut edge[i], at, before[i]);
            }
        }
        edge
    }
}

/// An instrument that is multiplied with others.
struct Row<'a, T, const N: usize> {
    one: Some<'a, T, 1>,
    others: Some<'a, T, N>,
    sums: [&'a mut [Lane]; 2],
}

impl<T: Signal, const N: usize> WithSimd for Row<'_, T, N> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { one, others, sums: [squares, neighbours] } = self;
        let zero = simd.splat_f64s(0.0);
        for at in 0..parts::<S>() {
            let ([mut one_before], mut before) = (one.before(simd, at), others.before(simd, at));
            for block in one.blocks.starts() {
                let (mut squared, mut after, mut ahead) = ([zero; N], [zero; N], [zero; N]);
                for t in 0..BLOCK {
                    let ([one_now], now) = (one.at(simd, block, t, at), others.at(simd, block, t, at));
                    for j in 0..N {
                        squared[j] = simd.mul_add_f64s(one_now, now[j], squared[j]);
                        after[j] = simd.mul_add_f64s(one_before, now[j], after[j]);
                        ahead[j] = simd.mul_add_f64s(one_now, before[j], ahead[j]);
                    }
                    (one_before, before) = (one_now, now);
                }
                for j in 0..N {
                    add(simd, &mut squares[j], at, squared[j]);
                    add(simd, &mut neighbours[j], at, after[j]);
                    add(simd, &mut neighbours[j], at, ahead[j]);
                }
            }
        }
    }
}

/// The residuals of `theta`, one lane per parameter, into `all`: surge, sway, yaw. `intercepts`: three per run and group.
#[inline(always)]
pub(crate) fn put_residuals<X: Instrument>(
    batch: &Batch<X>,
    kept: &Kept,
    theta: &[Lane],
    intercepts: Groups,
    all: &mut [Vec<Lane>; 3],
) {
    all.iter_mut().for_each(|residuals| residuals.resize(batch.samples().next_multiple_of(SPAN), Lane::ZERO));
    let mut intercepts = Constants::<BLOCK>::new(intercepts, 3);
    let orders = Order::of_batch(batch);
    let mut phi = Regressors::phi(batch, orders.each_ref().map(|order| 0..order.measured));
    let mut inputs = X::zeta(batch, kept, orders.each_ref().map(|order| order.measured..usize::MAX));
    let mut rest = theta;
    let less = orders.map(|Order { terms, .. }| {
        let slopes = rest.split_off(..terms.len()).unwrap_or_default();
        terms.iter().map(|i| Lane::ZERO - slopes[*i]).collect::<Vec<_>>()
    });
    for (k, count) in spans(0..batch.samples()) {
        phi.go_to(k, count);
        inputs.go_to(k, count);
        let mut at = k;
        while at < k + count {
            let (end, intercepts) = intercepts.over(at..k + count);
            for d in 0..3 {
                let terms = Terms {
                    blocks: Blocks::of(at - k..end - k),
                    increments: phi.increments(d),
                    intercepts: &intercepts[d],
                    measured: phi.terms(d),
                    inputs: inputs.terms(d),
                    less: &less[d],
                };
                terms.put(&mut all[d][k..k + SPAN]);
            }
            at = end;
        }
    }
    all.iter_mut().for_each(|residuals| residuals.truncate(batch.samples()));
}

/// Blocks of a degree of freedom, with the same intercepts in each.
#[derive(Clone, Copy)]
struct Terms<'a, M, I> {
    blocks: Blocks,
    increments: Difference<'a>,
    intercepts: &'a Block<Lane>,
    measured: M,
    inputs: I,
    /// Parameters of the measured terms and of those of inputs alone, negated.
    less: &'a [Lane],
}

/// Terms with measured states that are subtracted at once: each of their parameters fits a register.
const RESIDUALS_AT_ONCE: usize = 4;

impl<M: Signals, I: Signals> Terms<'_, M, I> {
    fn put(self, out: &mut [Lane]) {
        if self.measured.count() > RESIDUALS_AT_ONCE || self.inputs.count() > 1 {
            return self.add_many(out);
        }
        match (self.measured.count(), self.inputs.count()) {
            (0, 0) => self.add_few::<0, 0>(out),
            (0, _) => self.add_few::<0, 1>(out),
            (1, 0) => self.add_few::<1, 0>(out),
            (1, _) => self.add_few::<1, 1>(out),
            (2, 0) => self.add_few::<2, 0>(out),
            (2, _) => self.add_few::<2, 1>(out),
            (3, 0) => self.add_few::<3, 0>(out),
            (3, _) => self.add_few::<3, 1>(out),
            (_, 0) => self.add_few::<RESIDUALS_AT_ONCE, 0>(out),
            (_, _) => self.add_few::<RESIDUALS_AT_ONCE, 1>(out),
        }
    }

    /// All terms are subtracted at once.
    fn add_few<const C: usize, const D: usize>(self, out: &mut [Lane]) {
        let Self { blocks, increments, intercepts, measured, inputs, less } = self;
        let (measured, inputs) = (measured.some::<C>(0), inputs.some::<D>(0));
        let terms = Terms { blocks, increments, intercepts, measured, inputs, less };
        numerics::dispatch(Residuals { terms, out });
    }

    /// Terms are subtracted one after the other.
    fn add_many(self, out: &mut [Lane]) {
        let Self { blocks, increments, intercepts, measured, inputs, less } = self;
        let mut left = vec![Lane::ZERO; 3 * SPAN];
        fill(increments, &mut left);
        (0..SPAN).for_each(|t| left[3 * t] = left[3 * t] - intercepts[t % BLOCK]);
        let (of_measured, of_inputs) = less.split_at(measured.count());
        for (i, less) in of_measured.iter().enumerate() {
            numerics::dispatch(Less { term: measured.one(i), less, left: &mut left });
        }
        for (i, less) in of_inputs[..inputs.count()].iter().enumerate() {
            numerics::dispatch(Less { term: inputs.one(i), less, left: &mut left });
        }
        let (measured, inputs) = (measured.part(0..0), inputs.part(0..0));
        let increments = Difference([Column::of(&left), Column::ZERO]);
        Terms { blocks, increments, intercepts: &[Lane::ZERO; BLOCK], measured, inputs, less }
            .add_few::<0, 0>(out);
    }
}

/// A term that is subtracted with its parameter.
struct Less<'a, T> {
    term: T,
    less: &'a Lane,
    left: &'a mut Table,
}

impl<T: Signal> WithSimd for Less<'_, T> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { term, less, left } = self;
        for at in 0..parts::<S>() {
            for (t, row) in left.as_chunks_mut::<3>().0.iter_mut().take(SPAN).enumerate() {
                let left =
                    simd.mul_add_f64s(term.at(simd, t, at), part::<S>(less, at), part::<S>(&row[0], at));
                put::<S>(&mut row[0], at, left);
            }
        }
    }
}

/// Residuals of few terms.
struct Residuals<'a, M, I, const C: usize, const D: usize> {
    terms: Terms<'a, [M; C], [I; D]>,
    /// At the samples of the span.
    out: &'a mut [Lane],
}

impl<M: Signal, I: Signal, const C: usize, const D: usize> WithSimd for Residuals<'_, M, I, C, D> {
    type Output = ();

    #[allow(clippy::needless_range_loop)] // What iterators make of arrays is not always inlined, and then has no vectors.
    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { terms: Terms { blocks, increments, intercepts, measured, inputs, less }, out } = self;
        let zero = simd.splat_f64s(0.0);
        for at in 0..parts::<S>() {
            let (mut first, mut last) = ([zero; C], [zero; D]);
            for i in 0..C {
                first[i] = part::<S>(&less[i], at);
            }
            for i in 0..D {
                last[i] = part::<S>(&less[C + i], at);
            }
            for block in blocks.starts() {
                for (t, intercept) in intercepts.iter().enumerate() {
                    let t = block + t;
                    let increment = increments.at(simd, t, at);
                    let mut now = simd.sub_f64s(increment, part::<S>(intercept, at));
                    for i in 0..C {
                        now = simd.mul_add_f64s(measured[i].at(simd, t, at), first[i], now);
                    }
                    for i in 0..D {
                        now = simd.mul_add_f64s(inputs[i].at(simd, t, at), last[i], now);
                    }
                    put::<S>(&mut out[t], at, now);
                }
            }
        }
    }
}
