use std::ops::{Add, AddAssign, Mul, Sub};

use crate::{Arithmetic, Lane};

/// How many times [`crate::LANES`] runs are stepped at once where there are as many: none waits for itself then.
pub const GROUPS: usize = 4;

/// A number of each of `G` times [`crate::LANES`] runs. A step of a model waits for the one before it, operation by operation;
/// meanwhile a processor has time for other runs.
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
}
