//! Residuals.

use numerics::Lane;
use pulp::{Simd, WithSimd};

use super::columns::{Instrument, Kept, Zeta};
use super::regressors::{Order, Regressors, Table, fill};
use super::signals::{Blocks, Column, Difference, SPAN, Signal, Signals, spans};
use crate::Batch;
use crate::batch::{Constants, Groups};

use numerics::registers::{BLOCK, Block};
use numerics::registers::{part, parts, put};

/// The residuals of `theta`, one lane per parameter, into `all`: surge, sway, yaw. `intercepts`: three per run and group.
#[inline(always)]
pub(crate) fn put_residuals<X: Instrument>(
    batch: &Batch<X>,
    kept: &Kept,
    theta: &[Lane],
    intercepts: Groups,
    all: &mut [Vec<Lane>; 3],
) {
    all.iter_mut().for_each(|own| own.resize(batch.samples().next_multiple_of(SPAN), Lane::ZERO));
    let mut intercepts = Constants::<BLOCK>::new(intercepts, 3);
    let orders = Order::of_batch(batch);
    let mut phi = Regressors::phi(batch, orders.each_ref().map(|order| 0..order.measured));
    let mut inputs = X::zeta(batch, kept, orders.each_ref().map(|order| order.measured..usize::MAX));
    let mut rest = theta;
    let less = orders.map(|Order { terms, .. }| {
        let split_off = rest.split_off(..terms.len()).unwrap_or_default();
        terms.iter().map(|i| Lane::ZERO - split_off[*i]).collect::<Vec<_>>()
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
    all.iter_mut().for_each(|own| own.truncate(batch.samples()));
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
const AT_ONCE: usize = 4;

impl<M: Signals, I: Signals> Terms<'_, M, I> {
    fn put(self, out: &mut [Lane]) {
        if self.measured.count() > AT_ONCE || self.inputs.count() > 1 {
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
            (_, 0) => self.add_few::<AT_ONCE, 0>(out),
            (_, _) => self.add_few::<AT_ONCE, 1>(out),
        }
    }

    /// All terms are subtracted at once.
    fn add_few<const C: usize, const D: usize>(self, out: &mut [Lane]) {
        let Self { blocks, increments, intercepts, measured, inputs, less } = self;
        let (measured, inputs) = (measured.some::<C>(0), inputs.some::<D>(0));
        numerics::dispatch(Residuals { blocks, increments, intercepts, measured, inputs, less, out });
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
    blocks: Blocks,
    increments: Difference<'a>,
    intercepts: &'a Block<Lane>,
    measured: [M; C],
    inputs: [I; D],
    less: &'a [Lane],
    /// At the samples of the span.
    out: &'a mut [Lane],
}

impl<M: Signal, I: Signal, const C: usize, const D: usize> WithSimd for Residuals<'_, M, I, C, D> {
    type Output = ();

    #[allow(clippy::needless_range_loop)] // What iterators make of arrays is not always inlined, and then has no vectors.
    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { blocks, increments, intercepts, measured, inputs, less, out } = self;
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
