//! Passes over columns at one sample, in the processor's registers: by default compilers take eight columns at a time
//! and gather their numbers one by one.

use numerics::Lane;
use numerics::registers::{Block, part, parts, put};
use pulp::{Simd, WithSimd};

/// λ(k) = Aᵀλ(k+1) + W s(k) in every column of adjoints; A is the identity plus its derivatives by u, v, r, and zero
/// at the last sample.
pub(crate) struct Backward<'a, const N: usize> {
    pub slopes: Option<[[Lane; 3]; 3]>,
    pub weights: [Lane; 3],
    pub sensitivities: &'a [[Lane; 3]],
    pub adjoints: &'a mut [[Lane; N]],
}

impl<const N: usize> Backward<'_, N> {
    #[inline(always)]
    pub(crate) fn go(self) {
        numerics::dispatch_narrow(self);
    }
}

impl<const N: usize> WithSimd for Backward<'_, N> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { slopes, weights, sensitivities, adjoints } = self;
        for at in 0..parts::<S>() {
            let zero = simd.splat_f64s(0.0);
            let (mut by, mut weight) = ([[zero; 3]; 3], [zero; 3]);
            for d in 0..3 {
                weight[d] = part::<S>(&weights[d], at);
                for i in 0..3 {
                    by[d][i] = slopes.as_ref().map_or(zero, |slopes| part::<S>(&slopes[d][i], at));
                }
            }
            for (adjoint, s) in adjoints.iter_mut().zip(sensitivities) {
                let mut own = [zero; 3];
                for d in 0..3 {
                    own[d] = part::<S>(&adjoint[d], at);
                }
                let after = own;
                for i in 0..3 {
                    if slopes.is_some() {
                        let by_yaw = simd.mul_add_f64s(by[2][i], after[2], after[i]);
                        let by_sway = simd.mul_add_f64s(by[1][i], after[1], by_yaw);
                        own[i] = simd.mul_add_f64s(by[0][i], after[0], by_sway);
                    }
                    own[i] = simd.mul_add_f64s(weight[i], part::<S>(&s[i], at), own[i]);
                    put::<S>(&mut adjoint[i], at, own[i]);
                }
            }
        }
    }
}

/// Writes w₀x₀ + w₁x₁ + w₂x₂ of every column into row `row` of a block.
pub(crate) struct Weigh<'a, const N: usize> {
    pub weights: [Lane; 3],
    pub columns: &'a [[Lane; N]],
    pub blocks: &'a mut [Block<Lane>],
    pub row: usize,
}

impl<const N: usize> Weigh<'_, N> {
    #[inline(always)]
    pub(crate) fn go(self) {
        numerics::dispatch_narrow(self);
    }
}

impl<const N: usize> WithSimd for Weigh<'_, N> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { weights: [x, y, z], columns, blocks, row } = self;
        for at in 0..parts::<S>() {
            let [x, y, z] = [part::<S>(&x, at), part::<S>(&y, at), part::<S>(&z, at)];
            for (block, column) in blocks.iter_mut().zip(columns) {
                let sum = simd.mul_f64s(z, part::<S>(&column[2], at));
                let sum = simd.mul_add_f64s(y, part::<S>(&column[1], at), sum);
                put::<S>(&mut block[row], at, simd.mul_add_f64s(x, part::<S>(&column[0], at), sum));
            }
        }
    }
}

/// Writes entry `entry` of every column, times `factor`, into row `row` of a block.
pub(crate) struct Scale<'a, const N: usize> {
    pub factor: Lane,
    pub entry: usize,
    pub columns: &'a [[Lane; N]],
    pub blocks: &'a mut [Block<Lane>],
    pub row: usize,
}

impl<const N: usize> Scale<'_, N> {
    #[inline(always)]
    pub(crate) fn go(self) {
        numerics::dispatch_narrow(self);
    }
}

impl<const N: usize> WithSimd for Scale<'_, N> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { factor, entry, columns, blocks, row } = self;
        for at in 0..parts::<S>() {
            let factor = part::<S>(&factor, at);
            for (block, column) in blocks.iter_mut().zip(columns) {
                put::<S>(&mut block[row], at, simd.mul_f64s(factor, part::<S>(&column[entry], at)));
            }
        }
    }
}
