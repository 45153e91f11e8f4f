//! Passes over the samples for any model, span by span: branches per term are taken once for all samples of a span.

pub(crate) mod columns;
mod regressors;
pub(crate) mod squares;

use std::ops::Range;

use numerics::Lane;
use numerics::lanes::{self, BLOCK};
use pulp::Simd;

use crate::sums::parts;

/// Samples that a pass processes at once: several blocks, so that branches per term are rare, and few enough for the L1 cache.
const SPAN: usize = 4 * BLOCK;

/// The spans of samples `range`: first sample, count.
fn spans(range: Range<usize>) -> impl Iterator<Item = (usize, usize)> {
    parts::<SPAN>(range)
}

/// Some blocks of a span.
#[derive(Clone, Copy)]
struct Blocks {
    first: usize,
    end: usize,
}

impl Blocks {
    /// Those of samples `range`, the first of which begins a block.
    fn of(range: Range<usize>) -> Self {
        Self { first: range.start / BLOCK, end: range.end.div_ceil(BLOCK) }
    }

    /// The first sample of each. The compiler can see here that they are in a span.
    #[inline(always)]
    fn starts(self) -> impl Iterator<Item = usize> {
        (0..SPAN / BLOCK)
            .filter(move |block| self.first <= *block && *block < self.end)
            .map(|block| BLOCK * block)
    }
}

/// A signal at the samples of a span.
pub(crate) trait Signal: Copy {
    /// Register `part` of it at sample `t`.
    fn at<S: Simd>(self, simd: S, t: usize, part: usize) -> S::f64s;
}

/// Several signals.
pub(crate) trait Signals: Copy {
    /// One of them.
    type One: Signal;
    /// Zero at all samples.
    const ZERO: Self::One;
    /// How many.
    fn count(self) -> usize;
    /// One of them.
    fn one(self, i: usize) -> Self::One;
    /// Those in `range`.
    fn part(self, range: Range<usize>) -> Self;

    /// `C` of them, from `first` on.
    #[inline(always)]
    fn some<const C: usize>(self, first: usize) -> [Self::One; C] {
        let mut some = [Self::ZERO; C];
        for (i, one) in some.iter_mut().enumerate() {
            *one = self.one(first + i);
        }
        some
    }
}

/// From the first to the last entry of a column of a table with three columns at the samples of a span. All signals
/// are stored so: with a stride known at compile time, they are all read with one index.
#[derive(Clone, Copy)]
struct Column<'a>(&'a [Lane; 3 * SPAN - 2]);

static ZEROS: [Lane; 3 * SPAN - 2] = [Lane::ZERO; 3 * SPAN - 2];
static ONES: [Lane; 3 * SPAN - 2] = [Lane::ONE; 3 * SPAN - 2];

impl<'a> Column<'a> {
    /// Zeros.
    const ZERO: Self = Self(&ZEROS);

    /// Ones.
    const ONE: Self = Self(&ONES);

    /// The column that begins with `entries`.
    #[inline(always)]
    fn of(entries: &'a [Lane]) -> Self {
        entries.first_chunk().map_or(Self::ZERO, Self)
    }

    /// Register `part` of the entry of sample `t`.
    #[inline(always)]
    fn at<S: Simd>(self, t: usize, part: usize) -> S::f64s {
        lanes::part::<S>(&self.0[3 * t], part)
    }

    /// The entry of sample `t`.
    #[inline(always)]
    fn entry(self, t: usize) -> Lane {
        self.0[3 * t]
    }
}

/// The product of two columns, computed when it is read: that is faster than to write it and to read it again.
#[derive(Clone, Copy)]
struct Product<'a>([Column<'a>; 2]);

impl Signal for Product<'_> {
    #[inline(always)]
    fn at<S: Simd>(self, simd: S, t: usize, part: usize) -> S::f64s {
        let Self([one, two]) = self;
        simd.mul_f64s(one.at::<S>(t, part), two.at::<S>(t, part))
    }
}

/// The difference of two columns.
#[derive(Clone, Copy)]
struct Difference<'a>([Column<'a>; 2]);

impl Signal for Difference<'_> {
    #[inline(always)]
    fn at<S: Simd>(self, simd: S, t: usize, part: usize) -> S::f64s {
        let Self([one, two]) = self;
        simd.sub_f64s(one.at::<S>(t, part), two.at::<S>(t, part))
    }
}

/// The modulus of a column.
#[derive(Clone, Copy)]
struct Modulus<'a>(Column<'a>);

impl Signal for Modulus<'_> {
    #[inline(always)]
    fn at<S: Simd>(self, simd: S, t: usize, part: usize) -> S::f64s {
        simd.abs_f64s(self.0.at::<S>(t, part))
    }
}

/// A signal that all runs share.
impl Signal for &[f64; SPAN] {
    #[inline(always)]
    fn at<S: Simd>(self, simd: S, t: usize, _: usize) -> S::f64s {
        simd.splat_f64s(self[t])
    }
}

/// Columns of numbers that all runs share, from sample `k` on.
#[derive(Clone, Copy)]
struct Shared<'a> {
    columns: &'a [Vec<f64>],
    k: usize,
}

impl<'a> Signals for Shared<'a> {
    type One = &'a [f64; SPAN];
    const ZERO: Self::One = &[0.0; SPAN];

    #[inline(always)]
    fn count(self) -> usize {
        self.columns.len()
    }

    #[inline(always)]
    fn one(self, i: usize) -> &'a [f64; SPAN] {
        self.columns[i][self.k..].first_chunk().unwrap_or(Self::ZERO)
    }

    #[inline(always)]
    fn part(self, range: Range<usize>) -> Self {
        Self { columns: &self.columns[range], ..self }
    }
}
