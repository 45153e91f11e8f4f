use numerics::{Arithmetic, Lane, Wide};

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
