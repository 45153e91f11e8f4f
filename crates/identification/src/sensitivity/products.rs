use std::marker::PhantomData;

use vessel::Lane;

use super::unknowns::Unknowns;
use crate::batch::{BLOCK, Block, accumulate};

/// Σ over samples of the product of every two signals, [`BLOCK`] samples at a time. Signals stand in columns as unknowns do.
pub(crate) struct Products<X> {
    signals: usize,
    columns: Vec<Block<Lane>>,
    filled: usize,
    /// By signal its products with its own column and all after it.
    sums: Vec<Lane>,
    kind: PhantomData<X>,
}

impl<X: Unknowns> Products<X> {
    pub(crate) fn new(signals: usize) -> Self {
        let columns = signals.div_ceil(X::PER_COLUMN);
        let sums = (0..signals).map(|i| columns - i / X::PER_COLUMN).sum();
        Self {
            signals,
            columns: vec![[Lane::ZERO; BLOCK]; columns],
            filled: 0,
            sums: vec![Lane::ZERO; sums],
            kind: PhantomData,
        }
    }

    /// Column `c` at this sample.
    #[inline(always)]
    pub(crate) fn set(&mut self, c: usize, value: Lane) {
        self.columns[c][self.filled] = value;
    }

    /// Goes to the next sample: every column was set at this one.
    #[inline(always)]
    pub(crate) fn advance(&mut self) {
        self.filled += 1;
        if self.filled == BLOCK {
            self.add();
        }
    }

    #[inline(always)]
    fn add(&mut self) {
        self.filled = 0;
        let mut rest = &mut self.sums[..];
        for i in 0..self.signals {
            let others = &self.columns[i / X::PER_COLUMN..];
            let own = &others[0];
            let (row, after) = std::mem::take(&mut rest).split_at_mut(others.len());
            rest = after;
            accumulate(
                others,
                row,
                #[inline(always)]
                |t, other, sum| X::of_column(own[t], i).lane().fused(other, sum),
            );
        }
    }

    /// The sums over all samples.
    pub(crate) fn finish(mut self) -> Sums<X> {
        for signal in &mut self.columns {
            signal[self.filled..].fill(Lane::ZERO);
        }
        vessel::vectorized!(self.add());
        let mut first = 0;
        let mut row = |i: usize| {
            let own = first;
            first += self.columns.len() - i / X::PER_COLUMN;
            own
        };
        Sums { rows: (0..self.signals).map(&mut row).collect(), sums: self.sums, kind: PhantomData }
    }
}

/// What [`Products`] came to.
pub(crate) struct Sums<X> {
    /// Where the sums of each signal begin.
    rows: Vec<usize>,
    sums: Vec<Lane>,
    kind: PhantomData<X>,
}

impl<X: Unknowns> Sums<X> {
    /// Σ of signal `i` times signal `j`.
    pub(crate) fn at(&self, i: usize, j: usize) -> X {
        let (i, j) = (i.min(j), i.max(j));
        X::of_column(self.sums[self.rows[i] + j / X::PER_COLUMN - i / X::PER_COLUMN], j)
    }

    /// All of them: signals × signals.
    pub(crate) fn square(&self) -> Vec<X> {
        let n = self.rows.len();
        (0..n * n).map(|k| self.at(k / n, k % n)).collect()
    }
}
