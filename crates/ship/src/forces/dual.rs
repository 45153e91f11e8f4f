use std::ops::{Add, AddAssign, Mul, Sub};

use numerics::Arithmetic;

use crate::forces::Real;

/// A number with its derivatives by `N` unknowns (forward mode). More unknowns are taken `N` at a time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dual<X, const N: usize> {
    /// The number.
    pub value: X,
    /// Its derivatives.
    pub tangents: [X; N],
}

impl<X: Real, const N: usize> Dual<X, N> {
    /// A number that depends on no unknown.
    pub fn constant(value: X) -> Self {
        Self { value, tangents: [X::ZERO; N] }
    }

    /// Unknown `i` itself; a constant where there are not so many.
    pub fn unknown(value: X, i: usize) -> Self {
        let mut own = Self::constant(value);
        if let Some(tangent) = own.tangents.get_mut(i) {
            *tangent = X::ONE;
        }
        own
    }

    /// A function of this number with that `value` and that `slope`.
    #[inline(always)]
    fn chain(self, value: X, slope: X) -> Self {
        Self { value, tangents: self.tangents.map(|own| slope * own) }
    }

    /// A function of two numbers with that `value` and those slopes.
    #[inline(always)]
    fn both(self, other: Self, value: X, slopes: [X; 2]) -> Self {
        let tangents = std::array::from_fn(|i| slopes[0] * self.tangents[i] + slopes[1] * other.tangents[i]);
        Self { value, tangents }
    }
}

impl<X: Real, const N: usize> From<f64> for Dual<X, N> {
    #[inline(always)]
    fn from(value: f64) -> Self {
        Self::constant(X::from(value))
    }
}

macro_rules! by_parts {
    ($trait:ident, $method:ident) => {
        impl<X: Real, const N: usize> $trait for Dual<X, N> {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                let tangents = std::array::from_fn(|i| self.tangents[i].$method(other.tangents[i]));
                Self { value: self.value.$method(other.value), tangents }
            }
        }
    };
}
by_parts!(Add, add);
by_parts!(Sub, sub);

impl<X: Real, const N: usize> AddAssign for Dual<X, N> {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl<X: Real, const N: usize> Mul for Dual<X, N> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        self.both(other, self.value * other.value, [other.value, self.value])
    }
}

/// What is built or changed place by place is a constant: its tangents are 0.
impl<X: Real, const N: usize> Arithmetic for Dual<X, N> {
    const ZERO: Self = Self { value: X::ZERO, tangents: [X::ZERO; N] };
    const ONE: Self = Self { value: X::ONE, tangents: [X::ZERO; N] };
    #[inline(always)]
    fn modulus(self) -> Self {
        self.chain(self.value.modulus(), self.value.sign())
    }
    #[inline(always)]
    fn sign(self) -> Self {
        Self::constant(self.value.sign())
    }
    type Place = X::Place;
    #[inline(always)]
    fn at(&self, place: X::Place) -> f64 {
        self.value.at(place)
    }
    #[inline(always)]
    fn change<const M: usize>(own: &mut [Self; M], f: impl Fn(X::Place, [f64; M]) -> [f64; M]) {
        let mut values = own.map(|own| own.value);
        X::change(&mut values, f);
        *own = values.map(Self::constant);
    }
}

impl<X: Real, const N: usize> Real for Dual<X, N> {
    #[inline(always)]
    fn over(self, other: Self) -> Self {
        let (quotient, inverse) = (self.value.over(other.value), X::ONE.over(other.value));
        self.both(other, quotient, [inverse, (quotient * inverse).negated()])
    }

    /// Its slope at 0 counts as 0.
    #[inline(always)]
    fn root(self) -> Self {
        let root = self.value.root();
        let safe = root.if_positive(root, X::ONE);
        self.chain(root, root.if_positive(X::from(0.5).over(safe), X::ZERO))
    }

    fn exponential(self) -> Self {
        let value = self.value.exponential();
        self.chain(value, value)
    }

    fn sine_and_cosine(self) -> (Self, Self) {
        let (sine, cosine) = self.value.sine_and_cosine();
        (self.chain(sine, cosine), self.chain(cosine, sine.negated()))
    }

    /// Its slopes where both components are 0 count as 0.
    fn angle(self, ahead: Self) -> Self {
        let square = self.value.squared() + ahead.value.squared();
        let inverse = square.if_positive(X::ONE.over(square.if_positive(square, X::ONE)), X::ZERO);
        let slopes = [ahead.value * inverse, (self.value * inverse).negated()];
        self.both(ahead, self.value.angle(ahead.value), slopes)
    }

    #[inline(always)]
    fn if_positive(self, then: Self, other: Self) -> Self {
        let tangents = std::array::from_fn(|i| self.value.if_positive(then.tangents[i], other.tangents[i]));
        Self { value: self.value.if_positive(then.value, other.value), tangents }
    }
}
