use std::ops::{Add, AddAssign, Mul, Sub};

use numerics::{Arithmetic, Lane, Wide};

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
        let mut unknown = Self::constant(value);
        if let Some(tangent) = unknown.tangents.get_mut(i) {
            *tangent = X::ONE;
        }
        unknown
    }

    /// A function of this number with that `value` and that `slope`.
    #[inline(always)]
    fn chain(self, value: X, slope: X) -> Self {
        Self { value, tangents: self.tangents.map(|tangent| slope * tangent) }
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
    fn change<const M: usize>(numbers: &mut [Self; M], f: impl Fn(X::Place, [f64; M]) -> [f64; M]) {
        let mut values = numbers.map(|number| number.value);
        X::change(&mut values, f);
        *numbers = values.map(Self::constant);
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

/// A number type that forces are computed in: one number, lanes of runs, or either with tangents. Elementary functions
/// are those of `libm`, place by place, so that all give the same bits.
pub trait Real: Arithmetic {
    /// This divided by `other`.
    #[inline(always)]
    fn over(self, other: Self) -> Self {
        Self::of(|place| self.at(place) / other.at(place))
    }

    /// The square root; 0 below 0.
    #[inline(always)]
    fn root(self) -> Self {
        Self::of(|place| if self.at(place) > 0.0 { self.at(place).sqrt() } else { 0.0 * self.at(place) })
    }

    /// eˣ.
    fn exponential(self) -> Self {
        Self::of(|place| libm::exp(self.at(place)))
    }

    /// Sine and cosine.
    fn sine_and_cosine(self) -> (Self, Self) {
        (Self::of(|place| libm::sin(self.at(place))), Self::of(|place| libm::cos(self.at(place))))
    }

    /// The angle \[rad\] of a vector with this component across and that component `ahead`.
    fn angle(self, ahead: Self) -> Self {
        Self::of(|place| libm::atan2(self.at(place), ahead.at(place)))
    }

    /// `then` in places where this is above zero, else `other`.
    #[inline(always)]
    fn if_positive(self, then: Self, other: Self) -> Self {
        Self::of(|place| if self.at(place) > 0.0 { then.at(place) } else { other.at(place) })
    }

    /// −x.
    #[inline(always)]
    fn negated(self) -> Self {
        Self::ZERO - self
    }

    /// x².
    #[inline(always)]
    fn squared(self) -> Self {
        self * self
    }

    /// This times a plain number.
    #[inline(always)]
    fn times(self, factor: f64) -> Self {
        self * Self::from(factor)
    }
}

impl Real for f64 {}
impl Real for Lane {}
impl<const G: usize> Real for Wide<G> {}
