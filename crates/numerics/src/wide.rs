use std::ops::{Add, AddAssign, Mul, Sub};

use crate::{Arithmetic, LANES, Lane, Row};

/// How many times [`crate::LANES`] runs are stepped at once where there are as many, to hide the latency of a
/// step.
pub const GROUPS: usize = 4;

/// A number of each of `G` times [`crate::LANES`] runs. A step of a model waits for the previous one,
/// operation by operation; meanwhile the processor has time for other runs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wide<const G: usize>(pub [Lane; G]);

macro_rules! group_by_group {
    ($trait:ident, $method:ident) => {
        impl<const G: usize> $trait for Wide<G> {
            type Output = Self;
            #[inline(always)]
            fn $method(mut self, other: Self) -> Self {
                for (own, other) in self.0.iter_mut().zip(other.0) {
                    *own = own.$method(other);
                }
                self
            }
        }
    };
}
group_by_group!(Add, add);
group_by_group!(Sub, sub);
group_by_group!(Mul, mul);

impl<const G: usize> AddAssign for Wide<G> {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl<const G: usize> From<f64> for Wide<G> {
    #[inline(always)]
    fn from(value: f64) -> Self {
        Self([Lane::splat(value); G])
    }
}

impl<const G: usize> From<Lane> for Wide<G> {
    #[inline(always)]
    fn from(lane: Lane) -> Self {
        Self([lane; G])
    }
}

impl<const G: usize> Arithmetic for Wide<G> {
    const ZERO: Self = Self([Lane::ZERO; G]);
    const ONE: Self = Self([Lane::ONE; G]);
    #[inline(always)]
    fn modulus(self) -> Self {
        Self(self.0.map(Lane::abs))
    }
    #[inline(always)]
    fn sign(self) -> Self {
        Self(self.0.map(Lane::sign))
    }
    type Place = [usize; 2];
    #[inline(always)]
    fn at(&self, [group, lane]: [usize; 2]) -> f64 {
        self.0[group].0[lane]
    }
    #[allow(clippy::needless_range_loop)] // What iterators make of arrays is not always inlined, and then has no vectors.
    #[inline(always)]
    fn change<const N: usize>(own: &mut [Self; N], f: impl Fn([usize; 2], [f64; N]) -> [f64; N]) {
        for group in 0..G {
            let mut here = [[0.0; LANES]; N];
            for i in 0..N {
                here[i] = own[i].0[group].0;
            }
            for lane in 0..LANES {
                let mut now = [0.0; N];
                for i in 0..N {
                    now[i] = here[i][lane];
                }
                let found = f([group, lane], now);
                for i in 0..N {
                    here[i][lane] = found[i];
                }
            }
            for i in 0..N {
                own[i].0[group].0 = here[i];
            }
        }
    }
}

impl<const G: usize> Row<Wide<G>> for &[Lane] {
    #[inline(always)]
    fn up_to(self, count: usize) -> Self {
        &self[..count]
    }
    #[inline(always)]
    fn entry(&self, i: usize, [_, lane]: [usize; 2]) -> f64 {
        self[i].0[lane]
    }
}

impl<const G: usize> Row<Wide<G>> for [&[Lane]; G] {
    #[inline(always)]
    fn up_to(self, count: usize) -> Self {
        self.map(|own| &own[..count])
    }
    #[inline(always)]
    fn entry(&self, i: usize, [group, lane]: [usize; 2]) -> f64 {
        self[group][i].0[lane]
    }
}
