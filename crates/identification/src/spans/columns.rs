//! Sums of instruments, of regressors and of their products.

use std::ops::Range;

use vessel::{Lane, Number};

use super::kept::{Kept, Zeta};
use super::regressors::{ALL, Picked, Regressors, SPAN, Span, measured};
use crate::batch::{BLOCK, parts};
use crate::{Batch, DegreeSums};

/// Adds Σζ, Σζ² and everything with terms of inputs alone, over samples `range`.
#[inline(always)]
pub(crate) fn add_instruments<X: Number>(
    batch: &Batch<X>,
    kept: Option<&Kept<X>>,
    range: Range<usize>,
    sums: &mut [DegreeSums<Lane>; 3],
) {
    let measured = measured(batch.model);
    let mut zeta = Zeta::new(kept, batch, &range, ALL);
    let mut columns = sums.each_ref().map(|own| Columns::new(own.parameters(), own.parameters()));
    for (k, count) in parts::<SPAN>(range) {
        let zeta = zeta.at(batch, k, count);
        let mut first = 0;
        for (d, columns) in columns.iter_mut().enumerate() {
            let own = zeta.part(first..first + columns.height);
            first += columns.height;
            for i in 0..own.count() {
                let signal = own.signal(i);
                let others = if i < measured[d] { own.part(0..0) } else { own };
                columns.add(
                    i,
                    others,
                    #[inline(always)]
                    |t| signal[t].lane(),
                );
            }
        }
    }
    for (d, (own, columns)) in sums.iter_mut().zip(columns).enumerate() {
        let p = own.parameters();
        for (j, (products, [total, square])) in columns.each().enumerate() {
            own.a[j * (p + 1) + p] = total;
            own.instrument_squares[j] = square;
            if j >= measured[d] {
                (0..p).for_each(|i| own.a[i * (p + 1) + j] = products[i]);
                own.a[p * (p + 1) + j] = total;
                own.regressor_squares[j] = square;
            }
        }
    }
}

/// Adds everything with measured terms or Δy in it, over samples `range`.
#[inline(always)]
pub(crate) fn add_measured<X: Number>(
    batch: &Batch<X>,
    kept: Option<&Kept<X>>,
    range: Range<usize>,
    sums: &mut [DegreeSums<Lane>; 3],
) {
    let measured = measured(batch.model);
    let mut phi = Regressors::of(batch.model, measured.map(|measured| 0..measured));
    let mut zeta = Zeta::new(kept, batch, &range, ALL);
    let mut columns = [0, 1, 2].map(|d: usize| Columns::new(measured[d] + 1, sums[d].parameters()));
    let mut increments = [Lane::ZERO; SPAN];
    for (k, count) in parts::<SPAN>(range) {
        batch.phi(k, count, &mut phi);
        let zeta = zeta.at(batch, k, count);
        let mut first = 0;
        for (d, columns) in columns.iter_mut().enumerate() {
            let (regressors, own) =
                (phi.terms().part(first..first + measured[d]), zeta.part(first..first + columns.height));
            first += columns.height;
            for i in 0..measured[d] {
                let regressor = regressors.signal(i);
                columns.add(
                    i,
                    own,
                    #[inline(always)]
                    |t| regressor[t],
                );
            }
            if let Some(rows) = batch.between(k, count, d) {
                columns.add(
                    measured[d],
                    own,
                    #[inline(always)]
                    |t| rows[t + 1][d] - rows[t][d],
                );
            } else {
                batch.increments(k, count, d, &phi, &mut increments);
                columns.add(
                    measured[d],
                    own,
                    #[inline(always)]
                    |t| increments[t],
                );
            }
        }
    }
    for (d, (own, columns)) in sums.iter_mut().zip(columns).enumerate() {
        let p = own.parameters();
        for (j, (products, [total, square])) in columns.each().enumerate() {
            if j < measured[d] {
                (0..p).for_each(|i| own.a[i * (p + 1) + j] = products[i]);
                own.a[p * (p + 1) + j] = total;
                own.regressor_squares[j] = square;
            } else {
                own.b[..p].copy_from_slice(products);
                own.b[p] = total;
            }
        }
    }
}

/// A column of sums for each of several signals y: Σ ζ y of every instrument, Σ y and Σ y².
struct Columns {
    sums: Vec<Lane>,
    /// Instruments.
    height: usize,
}

/// Instruments that are multiplied at once: their sums have a register each.
const AT_ONCE: usize = 4;

impl Columns {
    fn new(count: usize, height: usize) -> Self {
        Self { sums: vec![Lane::ZERO; count * (height + 2)], height }
    }

    /// Of each signal its products' sums, its own and its squares'.
    fn each(&self) -> impl Iterator<Item = (&[Lane], [Lane; 2])> {
        self.sums.chunks_exact(self.height + 2).filter_map(|column| {
            let (products, ends) = column.split_last_chunk()?;
            Some((products, *ends))
        })
    }

    /// Adds the sums of a signal to its column, with those of its products with the first instruments.
    #[inline(always)]
    fn add<X: Number>(&mut self, column: usize, zeta: Picked<X>, y: impl Fn(usize) -> Lane + Copy) {
        let height = self.height;
        let column = &mut self.sums[column * (height + 2)..(column + 1) * (height + 2)];
        let (sums, ends) = column.split_at_mut(height);
        let mut done = 0;
        while zeta.count() - done > AT_ONCE {
            add_rows::<X, AT_ONCE, false>(zeta.some(done), y, &mut sums[done..], ends);
            done += AT_ONCE;
        }
        let sums = &mut sums[done..];
        match zeta.count() - done {
            0 => add_rows::<X, 0, true>(zeta.some(done), y, sums, ends),
            1 => add_rows::<X, 1, true>(zeta.some(done), y, sums, ends),
            2 => add_rows::<X, 2, true>(zeta.some(done), y, sums, ends),
            3 => add_rows::<X, 3, true>(zeta.some(done), y, sums, ends),
            _ => add_rows::<X, AT_ONCE, true>(zeta.some(done), y, sums, ends),
        }
    }
}

/// Adds Σ ζ y of `R` instruments to the first of `sums`; the `LAST` ones add Σ y and Σ y² to `ends`.
#[allow(clippy::needless_range_loop)] // What iterators make of arrays is not always inlined, and then has no vectors.
#[inline(always)]
fn add_rows<X: Number, const R: usize, const LAST: bool>(
    zeta: [&Span<X>; R],
    y: impl Fn(usize) -> Lane,
    sums: &mut [Lane],
    ends: &mut [Lane],
) {
    let (mut whole, mut both) = ([Lane::ZERO; R], [Lane::ZERO; 2]);
    whole.copy_from_slice(&sums[..R]);
    if LAST {
        both.copy_from_slice(ends);
    }
    for block in (0..SPAN).step_by(BLOCK) {
        let (mut own, mut total, mut square) = ([Lane::ZERO; R], Lane::ZERO, Lane::ZERO);
        for t in block..block + BLOCK {
            let y = y(t);
            for i in 0..R {
                own[i] = zeta[i][t].lane().fused(y, own[i]);
            }
            if LAST {
                total += y;
                square = y.fused(y, square);
            }
        }
        for i in 0..R {
            whole[i] += own[i];
        }
        both[0] += total;
        both[1] += square;
    }
    sums[..R].copy_from_slice(&whole);
    if LAST {
        ends.copy_from_slice(&both);
    }
}
