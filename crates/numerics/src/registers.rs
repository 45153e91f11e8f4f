//! Lanes in the processor's registers: where compilers, left to themselves, gather numbers one by one.

use pulp::Simd;

use crate::{LANES, Lane};

/// Samples that are summed up before their sum is added to the others.
pub const BLOCK: usize = 8;

/// A signal at [`BLOCK`] samples.
pub type Block<X> = [X; BLOCK];

/// The registers that a lane fills.
#[inline(always)]
pub fn parts<S: Simd>() -> usize {
    LANES / S::F64_LANES
}

/// Register `part` of a lane.
#[inline(always)]
pub fn part<S: Simd>(lane: &Lane, part: usize) -> S::f64s {
    S::as_simd_f64s(&lane.0).0[part]
}

/// Puts `value` into register `part` of a lane.
#[inline(always)]
pub fn put<S: Simd>(lane: &mut Lane, part: usize, value: S::f64s) {
    S::as_mut_simd_f64s(&mut lane.0).0[part] = value;
}

/// Adds `value` to register `part` of a lane.
#[inline(always)]
pub fn add<S: Simd>(simd: S, lane: &mut Lane, part: usize, value: S::f64s) {
    put::<S>(lane, part, simd.add_f64s(self::part::<S>(lane, part), value));
}
