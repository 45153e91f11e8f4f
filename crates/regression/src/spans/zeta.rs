use std::ops::Range;

use numerics::{Lane, Number};
use ship::engine::Compiled;

use super::regressors::{Order, Products, Regressors};
use super::signals::{SPAN, Shared, Signals};
use crate::Batch;
use crate::batch::AnyBatch;

/// ζ at all samples of a batch whose runs share it, evaluated once for all passes and for all batches that share it.
pub(crate) struct Kept {
    /// Per degree of freedom a column per term in the passes' order, with a span of zeros at its end; none if the
    /// runs do not share ζ.
    columns: [Vec<Vec<f64>>; 3],
}

impl Kept {
    /// Of a batch.
    pub(crate) fn of(batch: AnyBatch) -> Self {
        let AnyBatch::Shared(batch) = batch else { return Self { columns: Default::default() } };
        let orders = Order::of(batch.model);
        let mut columns = orders.each_ref().map(|order| vec![Vec::new(); order.terms.len()]);
        let mut terms = Compiled::new(batch.model, &vec![0.0; batch.model.parameters()]);
        let width = batch.model.exogenous();
        for k in 0..batch.samples() {
            let states = batch.instrument_states.as_chunks().0[k];
            terms.look(states, &batch.instrument_exogenous[width * k..width * (k + 1)], None);
            let mut first = 0;
            for (columns, order) in columns.iter_mut().zip(&orders) {
                for (column, i) in columns.iter_mut().zip(&order.terms) {
                    column.push(terms.term(first + i));
                }
                first += order.terms.len();
            }
        }
        columns.iter_mut().flatten().for_each(|column| column.extend([0.0; SPAN]));
        Self { columns }
    }
}

/// ζ, span by span.
pub(crate) trait Zeta {
    /// Terms of a degree of freedom.
    type Terms<'s>: Signals
    where
        Self: 's;
    /// Moves to samples `k..k + count`, `count` ≤ [`SPAN`].
    fn go_to(&mut self, k: usize, count: usize);
    /// The terms of degree of freedom `d` there; zero beyond.
    fn terms(&self, d: usize) -> Self::Terms<'_>;
}

/// The number type of ζ: lanes, or numbers that all runs share.
pub(crate) trait Instrument: Number {
    /// ζ of a batch, with the `terms` of each degree of freedom. `kept` is of the same batch.
    fn zeta<'s>(batch: &Batch<'s, Self>, kept: &'s Kept, terms: [Range<usize>; 3]) -> impl Zeta + 's;
}

impl Instrument for Lane {
    #[inline(always)]
    fn zeta<'s>(batch: &Batch<'s, Lane>, _: &'s Kept, terms: [Range<usize>; 3]) -> impl Zeta + 's {
        Regressors::zeta(batch, terms)
    }
}

impl Zeta for Regressors<'_> {
    type Terms<'s>
        = Products<'s>
    where
        Self: 's;

    #[inline(always)]
    fn go_to(&mut self, k: usize, count: usize) {
        self.go_to(k, count);
    }

    #[inline(always)]
    fn terms(&self, d: usize) -> Self::Terms<'_> {
        self.terms(d)
    }
}

impl Instrument for f64 {
    #[inline(always)]
    fn zeta<'s>(_: &Batch<'s, f64>, kept: &'s Kept, terms: [Range<usize>; 3]) -> impl Zeta + 's {
        OfShared { terms, columns: &kept.columns, last: None, k: 0 }
    }
}

/// ζ that runs share.
struct OfShared<'s> {
    /// The requested terms of each degree of freedom.
    terms: [Range<usize>; 3],
    columns: &'s [Vec<Vec<f64>>; 3],
    /// A shorter last span, zero beyond.
    last: Option<[Vec<Vec<f64>>; 3]>,
    k: usize,
}

impl Zeta for OfShared<'_> {
    type Terms<'s>
        = Shared<'s>
    where
        Self: 's;

    #[inline(always)]
    fn go_to(&mut self, k: usize, count: usize) {
        self.k = k;
        let padded = |column: &Vec<f64>| {
            let mut padded = column[k..k + count].to_vec();
            padded.resize(SPAN, 0.0);
            padded
        };
        self.last =
            (count < SPAN).then(|| self.columns.each_ref().map(|own| own.iter().map(padded).collect()));
    }

    #[inline(always)]
    fn terms(&self, d: usize) -> Shared<'_> {
        let (columns, k) = match &self.last {
            Some(last) => (&last[d], 0),
            None => (&self.columns[d], self.k),
        };
        let Range { start, end } = self.terms[d];
        Shared { columns: &columns[start..end.min(columns.len())], k }
    }
}
