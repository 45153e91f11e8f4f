use vessel::{LANES, Lane, Number};

use super::kalman::Gain;
use super::recordings::Recordings;
use super::levels::Levels;
use super::sweep::{Step, sweep};
use crate::batch::{BLOCK, Block, accumulate};

/// Sums of squares and products of errors e and sensitivities s = ∂x̂/∂(unknown), per state u, v, r.
#[derive(Clone, Debug, PartialEq)]
pub struct Linear {
    /// Number of samples.
    pub samples: f64,
    /// Σ e².
    pub squares: [f64; 3],
    /// Σ s e, an entry per free unknown.
    pub gradient: [Vec<f64>; 3],
    /// Σ s sᵀ, free × free row-major.
    pub normal: [Vec<f64>; 3],
}

impl Linear {
    /// Adds other samples.
    pub(crate) fn add(&mut self, other: &Self) {
        self.samples += other.samples;
        for d in 0..3 {
            self.squares[d] += other.squares[d];
            let pairs = self.gradient[d].iter_mut().zip(&other.gradient[d]);
            pairs.for_each(|(a, b)| *a += b);
            self.normal[d].iter_mut().zip(&other.normal[d]).for_each(|(a, b)| *a += b);
        }
    }

    /// Whether every number is one.
    pub(crate) fn finite(&self) -> bool {
        self.squares.iter().chain(self.normal.iter().flatten()).all(|x| x.is_finite())
    }

    /// Σ_d w_d (Σ s sᵀ, Σ s e).
    pub(crate) fn weighted(&self, weights: [f64; 3]) -> (Vec<f64>, Vec<f64>) {
        let mix = |parts: &[Vec<f64>; 3]| -> Vec<f64> {
            (0..parts[0].len()).map(|i| (0..3).map(|d| weights[d] * parts[d][i]).sum()).collect()
        };
        (mix(&self.normal), mix(&self.gradient))
    }
}

/// Linearises predictions at `unknowns`: what a sum of squared errors and its Gauss–Newton step are made of, per lane. With
/// gains errors and sensitivities are whitened. Sample 0 counts where `from_start`.
pub(crate) fn linearize<X: Number, const N: usize>(
    recordings: &Recordings<X>,
    unknowns: &[Lane],
    free: &[usize],
    levels: Option<&Levels>,
    gains: &[Gain<N>],
    from_start: bool,
) -> Vec<Linear> {
    let longest = recordings.longest();
    let even = recordings.samples.iter().all(|n| *n == longest);
    let mut sums = Triangles::new(free.len() + 1);
    sweep(
        recordings,
        unknowns,
        free,
        levels,
        gains,
        #[inline(always)]
        |step: Step<'_, N>| {
            if step.k == 0 && !from_start {
                return;
            }
            let mask = if even { Lane::ONE } else { recordings.lasting(step.k) };
            let gain = gains.get(step.k);
            let seen = |x: [Lane; 3]| {
                let white = gain.map_or(x, |gain| gain.white(&x));
                if even { white } else { white.map(|x| x * mask) }
            };
            for (i, s) in step.sensitivities.iter().enumerate() {
                sums.set(i, seen([s[0], s[1], s[2]]));
            }
            sums.set(free.len(), seen(step.error));
            sums.advance();
        },
    );
    sums.flush();
    let first = usize::from(!from_start);
    (0..LANES).map(|lane| sums.lane(lane, recordings.samples[lane] + 1 - first)).collect()
}

/// Σ of products of every two signals, per state, [`BLOCK`] samples at a time.
struct Triangles {
    signals: usize,
    blocks: [Vec<Block<Lane>>; 3],
    filled: usize,
    sums: [Vec<Lane>; 3],
}

impl Triangles {
    fn new(signals: usize) -> Self {
        let each = || vec![[Lane::ZERO; BLOCK]; signals];
        let sums = || vec![Lane::ZERO; signals * (signals + 1) / 2];
        Self { signals, blocks: [each(), each(), each()], filled: 0, sums: [sums(), sums(), sums()] }
    }

    /// Signal `i` at this sample.
    #[inline(always)]
    fn set(&mut self, i: usize, values: [Lane; 3]) {
        for (block, value) in self.blocks.iter_mut().zip(values) {
            block[i][self.filled] = value;
        }
    }

    #[inline(always)]
    fn advance(&mut self) {
        self.filled += 1;
        if self.filled == BLOCK {
            self.add();
        }
    }

    /// Adds what is left.
    fn flush(&mut self) {
        for signal in self.blocks.iter_mut().flatten() {
            signal[self.filled..].fill(Lane::ZERO);
        }
        pulp::Arch::new().dispatch(Rest(self));
    }

    #[inline(always)]
    fn add(&mut self) {
        self.filled = 0;
        for (blocks, sums) in self.blocks.iter().zip(&mut self.sums) {
            let mut place = 0;
            for (i, own) in blocks.iter().enumerate() {
                let entries = place..place + self.signals - i;
                place = entries.end;
                accumulate(
                    &blocks[i..],
                    &mut sums[entries],
                    #[inline(always)]
                    |t, other| own[t] * other,
                );
            }
        }
    }

    fn lane(&self, lane: usize, samples: usize) -> Linear {
        let p = self.signals - 1;
        let place = |i: usize, j: usize| i * self.signals - i * (i + 1) / 2 + j;
        let at = |d: usize, i: usize, j: usize| self.sums[d][place(i.min(j), i.max(j))][lane];
        Linear {
            samples: samples as f64,
            squares: [0, 1, 2].map(|d| at(d, p, p)),
            gradient: [0, 1, 2].map(|d| (0..p).map(|i| at(d, i, p)).collect()),
            normal: [0, 1, 2].map(|d| (0..p * p).map(|k| at(d, k / p, k % p)).collect()),
        }
    }
}

/// The last block, compiled like the others.
struct Rest<'a>(&'a mut Triangles);

impl pulp::WithSimd for Rest<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) {
        self.0.add();
    }
}
