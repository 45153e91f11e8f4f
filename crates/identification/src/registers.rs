//! Lanes in the processor's registers: where compilers, left to themselves, gather numbers one by one.

use numerics::{LANES, Lane};
use pulp::Simd;

/// The registers that a lane fills.
#[inline(always)]
pub(crate) fn parts<S: Simd>() -> usize {
    LANES / S::F64_LANES
}

/// Register `part` of a lane.
#[inline(always)]
pub(crate) fn part<S: Simd>(lane: &Lane, part: usize) -> S::f64s {
    S::as_simd_f64s(&lane.0).0[part]
}

/// Puts `value` into register `part` of a lane.
#[inline(always)]
pub(crate) fn put<S: Simd>(lane: &mut Lane, part: usize, value: S::f64s) {
    S::as_mut_simd_f64s(&mut lane.0).0[part] = value;
}

/// Adds `value` to register `part` of a lane.
#[inline(always)]
pub(crate) fn add<S: Simd>(simd: S, lane: &mut Lane, part: usize, value: S::f64s) {
    put::<S>(lane, part, simd.add_f64s(self::part::<S>(lane, part), value));
}
