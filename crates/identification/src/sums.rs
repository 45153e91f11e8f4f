use std::ops::Range;

use vessel::Lane;

use crate::Batch;
use crate::batch::{BLOCK, Block, Regressors, dot, total};

/// Sums over regression pairs of all degrees of freedom. The sums of two pieces of data add to those of both.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Sums {
    /// Number of pairs N.
    pub samples: u64,
    /// Surge, sway, yaw.
    pub degrees: Vec<DegreeSums>,
}

/// Sums of one degree of freedom with p parameters; p̃ = p + 1.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DegreeSums {
    /// A = Σ ζ̃ φ̃ᵀ, p̃ × p̃, row-major. The last row holds Σ φ, the last column Σ ζ, the corner N.
    pub a: Vec<f64>,
    /// b = Σ ζ̃ Δy, p̃.
    pub b: Vec<f64>,
    /// Σ ζ_i², p.
    pub instrument_squares: Vec<f64>,
    /// Σ φ_i², p.
    pub regressor_squares: Vec<f64>,
}

impl Sums {
    /// Adds the sums of further data.
    pub fn merge(&mut self, other: &Self) {
        if self.degrees.is_empty() {
            self.clone_from(other);
            return;
        }
        self.samples += other.samples;
        for (own, other) in self.degrees.iter_mut().zip(&other.degrees) {
            add(&mut own.a, &other.a);
            add(&mut own.b, &other.b);
            add(&mut own.instrument_squares, &other.instrument_squares);
            add(&mut own.regressor_squares, &other.regressor_squares);
        }
    }
}

fn add(own: &mut [f64], other: &[f64]) {
    own.iter_mut().zip(other).for_each(|(a, b)| *a += b);
}

impl DegreeSums {
    /// Number of parameters p.
    pub fn parameters(&self) -> usize {
        self.instrument_squares.len()
    }
}

/// [`Sums`] of a batch, lane by lane, laid out one degree of freedom after the other: a, b, squares.
pub(crate) struct LaneSums {
    entries: Vec<Lane>,
    parameters: Vec<usize>,
    samples: usize,
}

impl LaneSums {
    /// The sums over samples `range` of `batch`.
    pub(crate) fn over(batch: &Batch, range: Range<usize>) -> Self {
        let parameters: Vec<usize> = batch.model.degrees.iter().map(|d| d.terms.len()).collect();
        let size = parameters.iter().map(|p| entries(*p)).sum();
        let mut sums = Self { entries: vec![Lane::ZERO; size], parameters, samples: range.len() };
        pulp::Arch::new().dispatch(Accumulate { sums: &mut sums, batch, range });
        sums
    }

    /// The sums of one lane.
    pub(crate) fn lane(&self, lane: usize) -> Sums {
        let mut start = 0;
        let degree = |p: &usize| {
            let own: Vec<f64> = self.entries[start..start + entries(*p)].iter().map(|e| e[lane]).collect();
            start += entries(*p);
            let lifted = p + 1;
            let (a, rest) = own.split_at(lifted * lifted);
            let (b, squares) = rest.split_at(lifted);
            let mut a = a.to_vec();
            a[lifted * lifted - 1] = self.samples as f64;
            let (zeta, phi) = squares.split_at(*p);
            DegreeSums {
                a,
                b: b.to_vec(),
                instrument_squares: zeta.to_vec(),
                regressor_squares: phi.to_vec(),
            }
        };
        Sums { samples: self.samples as u64, degrees: self.parameters.iter().map(degree).collect() }
    }
}

/// Adds the products of samples `range`; compiled for every instruction set that pulp picks from.
struct Accumulate<'a> {
    sums: &'a mut LaneSums,
    batch: &'a Batch<'a>,
    range: Range<usize>,
}

impl pulp::WithSimd for Accumulate<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) {
        let batch = self.batch;
        let (mut phi, mut zeta) = (Regressors::new(batch.model), Regressors::new(batch.model));
        let mut k = self.range.start;
        while k < self.range.end {
            let count = BLOCK.min(self.range.end - k);
            batch.regressors(batch.measured, k, count, &mut phi);
            batch.regressors(batch.instrument_states, k, count, &mut zeta);
            let (mut entries, mut first) = (&mut self.sums.entries[..], 0);
            for (d, p) in self.sums.parameters.iter().copied().enumerate() {
                let (own, rest) = entries.split_at_mut(self::entries(p));
                let increments = batch.increments(k, count, d);
                add_block(own, &zeta.terms[first..first + p], &phi.terms[first..first + p], &increments);
                (entries, first) = (rest, first + p);
            }
            k += count;
        }
    }
}

fn entries(p: usize) -> usize {
    (p + 1) * (p + 1) + (p + 1) + 2 * p
}

/// Adds the products of a block of samples. Layout of `out`: a (p̃ × p̃), b (p̃), Σζ², Σφ².
#[inline(always)]
fn add_block(out: &mut [Lane], zeta: &[Block], phi: &[Block], increments: &Block) {
    let p = zeta.len();
    let lifted = p + 1;
    let (a, rest) = out.split_at_mut(lifted * lifted);
    let (b, squares) = rest.split_at_mut(lifted);
    for (i, z) in zeta.iter().enumerate() {
        let row = &mut a[i * lifted..(i + 1) * lifted];
        for (entry, f) in row.iter_mut().zip(phi) {
            *entry += dot(z, f);
        }
        row[p] += total(z);
        b[i] += dot(z, increments);
        squares[i] += dot(z, z);
    }
    for (i, f) in phi.iter().enumerate() {
        a[p * lifted + i] += total(f);
        squares[p + i] += dot(f, f);
    }
    b[p] += total(increments);
}
