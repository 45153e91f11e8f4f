//! Sums of instruments, of regressors and of their products.

use std::ops::Range;

use numerics::lanes::{BLOCK, add, parts};
use numerics::{Lane, Number};
use pulp::{Simd, WithSimd};
use ship::engine::Compiled;

use super::regressors::{ALL, Order, Products, Regressors};
use super::{Difference, SPAN, Shared, Signal, Signals, spans};
use crate::sums::AnyBatch;
use crate::{Batch, DegreeSums};

/// Adds Σζ, Σζ² and all sums with terms of inputs alone, over samples `range`.
#[inline(always)]
pub(crate) fn add_instruments<X: Instrument>(
    batch: &Batch<X>,
    kept: &Kept,
    range: Range<usize>,
    sums: &mut [DegreeSums<Lane>; 3],
) {
    let orders = Order::of_batch(batch);
    let mut zeta = X::zeta(batch, kept, ALL);
    let mut columns = [0, 1, 2].map(|d: usize| {
        let p = sums[d].parameters();
        Columns::new(p - orders[d].measured, p)
    });
    for (k, count) in spans(range) {
        zeta.go_to(k, count);
        for (d, columns) in columns.iter_mut().enumerate() {
            let all = zeta.terms(d);
            columns.add::<Difference, 0>(all.part(orders[d].measured..all.count()), all, []);
        }
    }
    for ((degree, columns), Order { terms, measured }) in sums.iter_mut().zip(columns).zip(&orders) {
        let p = degree.parameters();
        for (place, (i, (products, [total, square]))) in terms.iter().zip(columns.each()).enumerate() {
            degree.a[i * (p + 1) + p] = total;
            degree.instrument_squares[*i] = square;
            for (j, product) in terms[*measured..].iter().zip(products) {
                degree.a[i * (p + 1) + j] = *product;
            }
            if place >= *measured {
                degree.a[p * (p + 1) + i] = total;
                degree.regressor_squares[*i] = square;
            }
        }
    }
}

/// Adds all sums with measured terms or Δy, over samples `range`.
#[inline(always)]
pub(crate) fn add_measured<X: Instrument>(
    batch: &Batch<X>,
    kept: &Kept,
    range: Range<usize>,
    sums: &mut [DegreeSums<Lane>; 3],
) {
    let orders = Order::of_batch(batch);
    let mut phi = Regressors::phi(batch, orders.each_ref().map(|order| 0..order.measured));
    let mut zeta = X::zeta(batch, kept, ALL);
    let mut columns = [0, 1, 2].map(|d: usize| Columns::new(sums[d].parameters(), orders[d].measured + 1));
    for (k, count) in spans(range) {
        phi.go_to(k, count);
        zeta.go_to(k, count);
        for (d, columns) in columns.iter_mut().enumerate() {
            columns.add(zeta.terms(d), phi.terms(d), [phi.increments(d)]);
        }
    }
    for ((degree, columns), Order { terms, measured }) in sums.iter_mut().zip(columns).zip(&orders) {
        let p = degree.parameters();
        for (place, (products, [total, square])) in columns.each().enumerate() {
            for (i, product) in terms.iter().zip(products) {
                if place < *measured {
                    degree.a[i * (p + 1) + terms[place]] = *product;
                } else {
                    degree.b[*i] = *product;
                }
            }
            if place < *measured {
                degree.a[p * (p + 1) + terms[place]] = total;
                degree.regressor_squares[terms[place]] = square;
            } else {
                degree.b[p] = total;
            }
        }
    }
}

/// A column of sums for each of several signals y: Σ x y with every one of others, Σ y and Σ y².
struct Columns {
    sums: Vec<Lane>,
    /// The number of others.
    height: usize,
}

/// Signals of either kind that are multiplied at once: each of their sums fits a register.
const AT_ONCE: usize = 4;

impl Columns {
    fn new(height: usize, count: usize) -> Self {
        Self { sums: vec![Lane::ZERO; count * (height + 2)], height }
    }

    /// Per signal the sums of its products, of itself and of its square.
    fn each(&self) -> impl Iterator<Item = (&[Lane], [Lane; 2])> {
        self.sums.chunks_exact(self.height + 2).filter_map(|column| {
            let (products, ends) = column.split_last_chunk()?;
            Some((products, *ends))
        })
    }

    /// Adds the sums of all signals y, `last` after the others, and of the products with all x.
    fn add<Z: Signal, const E: usize>(&mut self, x: impl Signals, y: impl Signals, last: [Z; E]) {
        let mut first = 0;
        while y.count() - first >= AT_ONCE {
            self.add_columns::<_, Z, AT_ONCE, 0>(x, first, y.some(first), []);
            first += AT_ONCE;
        }
        match y.count() - first {
            0 => self.add_columns::<_, _, 0, E>(x, first, y.some(first), last),
            1 => self.add_columns::<_, _, 1, E>(x, first, y.some(first), last),
            2 => self.add_columns::<_, _, 2, E>(x, first, y.some(first), last),
            _ => self.add_columns::<_, _, 3, E>(x, first, y.some(first), last),
        }
    }

    /// [`Self::add`] of few columns, the first of which is `first`.
    fn add_columns<Y: Signal, Z: Signal, const C: usize, const E: usize>(
        &mut self,
        x: impl Signals,
        first: usize,
        y: [Y; C],
        last: [Z; E],
    ) {
        let Self { sums, height } = self;
        let mut to = To { sums: &mut sums[first * (*height + 2)..], height: *height, row: 0 };
        while *height - to.row > AT_ONCE {
            to.add::<_, _, _, AT_ONCE, C, E>(x.some(to.row), y, last);
            to.row += AT_ONCE;
        }
        match *height - to.row {
            0 => to.add::<_, _, _, 0, C, E>(x.some(to.row), y, last),
            1 => to.add::<_, _, _, 1, C, E>(x.some(to.row), y, last),
            2 => to.add::<_, _, _, 2, C, E>(x.some(to.row), y, last),
            3 => to.add::<_, _, _, 3, C, E>(x.some(to.row), y, last),
            _ => to.add::<_, _, _, AT_ONCE, C, E>(x.some(to.row), y, last),
        }
    }
}

/// Columns that sums are added to, products from `row` on. From row 0 on, Σ y and Σ y² are added, too.
struct To<'a> {
    sums: &'a mut [Lane],
    height: usize,
    row: usize,
}

impl To<'_> {
    fn add<X: Signal, Y: Signal, Z: Signal, const R: usize, const C: usize, const E: usize>(
        &mut self,
        x: [X; R],
        y: [Y; C],
        last: [Z; E],
    ) {
        if C + E > 0 {
            numerics::dispatch(Tile { x, y, last, to: self });
        }
    }

    /// Adds to column `j`.
    #[inline(always)]
    fn put<S: Simd, const R: usize>(
        &mut self,
        simd: S,
        j: usize,
        at: usize,
        row_sums: [S::f64s; R],
        ends: [S::f64s; 2],
    ) {
        let column = &mut self.sums[j * (self.height + 2)..(j + 1) * (self.height + 2)];
        let (products, both) = column.split_at_mut(self.height);
        for (sum, row_sum) in products[self.row..self.row + R].iter_mut().zip(row_sums) {
            add(simd, sum, at, row_sum);
        }
        if self.row == 0 {
            add(simd, &mut both[0], at, ends[0]);
            add(simd, &mut both[1], at, ends[1]);
        }
    }
}

/// Signals x and y, few enough that each sum of their products fits a register.
struct Tile<'a, 'b, X, Y, Z, const R: usize, const C: usize, const E: usize> {
    x: [X; R],
    y: [Y; C],
    last: [Z; E],
    to: &'a mut To<'b>,
}

impl<X: Signal, Y: Signal, Z: Signal, const R: usize, const C: usize, const E: usize> WithSimd
    for Tile<'_, '_, X, Y, Z, R, C, E>
{
    type Output = ();

    #[allow(clippy::needless_range_loop)] // What iterators make of arrays is not always inlined, and then has no vectors.
    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { x, y, last, to } = self;
        let zero = simd.splat_f64s(0.0);
        for at in 0..parts::<S>() {
            for block in (0..SPAN).step_by(BLOCK) {
                let (mut row_sums, mut ends) = ([[zero; R]; C], [[zero; 2]; C]);
                let (mut last_sums, mut last_ends) = ([[zero; R]; E], [[zero; 2]; E]);
                for t in block..block + BLOCK {
                    let mut now = [zero; R];
                    for i in 0..R {
                        now[i] = x[i].at(simd, t, at);
                    }
                    for j in 0..C {
                        add_one(simd, now, y[j].at(simd, t, at), &mut row_sums[j], &mut ends[j]);
                    }
                    for j in 0..E {
                        add_one(simd, now, last[j].at(simd, t, at), &mut last_sums[j], &mut last_ends[j]);
                    }
                }
                for j in 0..C {
                    to.put(simd, j, at, row_sums[j], ends[j]);
                }
                for j in 0..E {
                    to.put(simd, C + j, at, last_sums[j], last_ends[j]);
                }
            }
        }
    }
}

/// Adds the products of y with some x, y and its square.
#[inline(always)]
fn add_one<S: Simd, const R: usize>(
    simd: S,
    x: [S::f64s; R],
    y: S::f64s,
    row_sums: &mut [S::f64s; R],
    ends: &mut [S::f64s; 2],
) {
    for i in 0..R {
        row_sums[i] = simd.mul_add_f64s(x[i], y, row_sums[i]);
    }
    ends[0] = simd.add_f64s(ends[0], y);
    ends[1] = simd.mul_add_f64s(y, y, ends[1]);
}

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
            (count < SPAN).then(|| self.columns.each_ref().map(|column| column.iter().map(padded).collect()));
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
