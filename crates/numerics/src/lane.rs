use std::ops::{Add, AddAssign, Div, Index, IndexMut, Mul, Sub};

/// Number of runs in a lane.
pub const LANES: usize = 8;

/// One number of each of [`LANES`] runs. Every lane is computed on its own, in the same order of operations,
/// so a run's numbers do not depend on the other runs of the lane.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C, align(64))]
pub struct Lane(pub [f64; LANES]);

impl Lane {
    /// Zero in every lane.
    pub const ZERO: Self = Self([0.0; LANES]);
    /// One in every lane.
    pub const ONE: Self = Self([1.0; LANES]);

    /// The same number in every lane.
    #[inline(always)]
    pub const fn splat(value: f64) -> Self {
        Self([value; LANES])
    }

    /// This times `factor` plus `other`, rounded once: the same bits on every processor. Without an
    /// instruction for it, it takes a hundred times as long.
    #[inline(always)]
    pub fn fused(mut self, factor: Self, other: Self) -> Self {
        for lane in 0..LANES {
            self.0[lane] = self.0[lane].mul_add(factor.0[lane], other.0[lane]);
        }
        self
    }
}

macro_rules! of_each_lane {
    ($($about:literal $function:ident = $of:expr;)+) => {
        impl Lane {
            $(#[doc = $about]
            #[inline(always)]
            pub fn $function(mut self) -> Self {
                for value in &mut self.0 {
                    *value = $of(*value);
                }
                self
            })+
        }
    };
}
of_each_lane! {
    "Modulus, lane by lane." abs = f64::abs;
    "−1, 0 or 1, lane by lane." sign = Arithmetic::sign;
    "Square root, lane by lane." sqrt = f64::sqrt;
    "1/x, lane by lane." recip = f64::recip;
}

macro_rules! lane_by_lane {
    ($trait:ident, $method:ident, $assign:tt) => {
        impl $trait for Lane {
            type Output = Lane;
            #[inline(always)]
            fn $method(mut self, other: Lane) -> Lane {
                for (value, other) in self.0.iter_mut().zip(other.0) {
                    *value $assign other;
                }
                self
            }
        }
    };
}
lane_by_lane!(Add, add, +=);
lane_by_lane!(Sub, sub, -=);
lane_by_lane!(Mul, mul, *=);
lane_by_lane!(Div, div, /=);

impl AddAssign for Lane {
    #[inline(always)]
    fn add_assign(&mut self, other: Lane) {
        *self = *self + other;
    }
}

impl From<f64> for Lane {
    #[inline(always)]
    fn from(value: f64) -> Self {
        Self::splat(value)
    }
}

/// The number type that a model is stepped with: a [`Lane`], several of them, or one number. All give the same bits.
pub trait Arithmetic:
    Copy
    + std::fmt::Debug
    + Send
    + Sync
    + Add<Output = Self>
    + AddAssign
    + Sub<Output = Self>
    + Mul<Output = Self>
    + From<f64>
{
    /// Zero.
    const ZERO: Self;
    /// One.
    const ONE: Self;
    /// |x|.
    fn modulus(self) -> Self;
    /// −1, 0 or 1.
    fn sign(self) -> Self;
    /// The index of one of its numbers.
    type Place: Copy;
    /// The number at an index.
    fn at(&self, place: Self::Place) -> f64;
    /// Applies `f` to `numbers`, place by place. The loop over the lanes stays in one piece until it is vectorized, so that the
    /// compiler produces whole vectors even for values that are carried from sample to sample.
    fn change<const N: usize>(numbers: &mut [Self; N], f: impl Fn(Self::Place, [f64; N]) -> [f64; N]);
    /// Built from the number at every place.
    #[inline(always)]
    fn of(f: impl Fn(Self::Place) -> f64) -> Self {
        let mut whole = [Self::ZERO];
        Self::change(&mut whole, |place, _| [f(place)]);
        whole[0]
    }
}

/// The exogenous values of a vessel during a sample: its inputs and measured disturbances.
pub trait Row<X: Arithmetic>: Copy {
    /// The first `count` of them, which must exist.
    fn up_to(self, count: usize) -> Self;
    /// One of them at a place.
    fn entry(&self, i: usize, place: X::Place) -> f64;
}

impl<X: Arithmetic> Row<X> for &[f64] {
    #[inline(always)]
    fn up_to(self, count: usize) -> Self {
        &self[..count]
    }
    #[inline(always)]
    fn entry(&self, i: usize, _: X::Place) -> f64 {
        self[i]
    }
}

/// The number type of a signal: a [`Lane`], or one number, of a single run or of all.
pub trait Number: Arithmetic + Div<Output = Self> + Into<Lane> {
    /// The number of every run.
    fn lane(self) -> Lane;
    /// `f` of this number and `other`, run by run.
    fn each(self, other: Self, f: impl Fn(f64, f64) -> f64) -> Self;
    /// A slice with its number type erased.
    fn numbers(entries: &[Self]) -> Numbers<'_>;
}

/// Numbers of either kind. A function of these is compiled once, in its own crate; one that is generic over
/// [`Number`] is compiled, for every instruction set, in every crate and test that calls it.
#[derive(Clone, Copy, Debug)]
pub enum Numbers<'a> {
    /// A lane per entry.
    Lanes(&'a [Lane]),
    /// One number per entry, which all runs share.
    Shared(&'a [f64]),
}

impl Arithmetic for Lane {
    const ZERO: Self = Self::ZERO;
    const ONE: Self = Self::ONE;
    #[inline(always)]
    fn modulus(self) -> Self {
        self.abs()
    }
    #[inline(always)]
    fn sign(self) -> Self {
        self.sign()
    }
    type Place = usize;
    #[inline(always)]
    fn at(&self, lane: usize) -> f64 {
        self.0[lane]
    }
    #[inline(always)]
    fn change<const N: usize>(numbers: &mut [Self; N], f: impl Fn(usize, [f64; N]) -> [f64; N]) {
        for lane in 0..LANES {
            let changed = f(lane, std::array::from_fn(|i| numbers[i].0[lane]));
            for i in 0..N {
                numbers[i].0[lane] = changed[i];
            }
        }
    }
}

impl Number for Lane {
    #[inline(always)]
    fn lane(self) -> Lane {
        self
    }
    #[inline(always)]
    fn each(mut self, other: Self, f: impl Fn(f64, f64) -> f64) -> Self {
        for (value, other) in self.0.iter_mut().zip(other.0) {
            *value = f(*value, other);
        }
        self
    }
    fn numbers(entries: &[Self]) -> Numbers<'_> {
        Numbers::Lanes(entries)
    }
}

impl Arithmetic for f64 {
    const ZERO: Self = 0.0;
    const ONE: Self = 1.0;
    #[inline(always)]
    fn modulus(self) -> Self {
        self.abs()
    }
    #[inline(always)]
    fn sign(self) -> Self {
        if self == 0.0 { 0.0 } else { 1.0_f64.copysign(self) }
    }
    type Place = ();
    #[inline(always)]
    fn at(&self, (): ()) -> f64 {
        *self
    }
    #[inline(always)]
    fn change<const N: usize>(numbers: &mut [Self; N], f: impl Fn((), [f64; N]) -> [f64; N]) {
        *numbers = f((), *numbers);
    }
}

impl Number for f64 {
    #[inline(always)]
    fn lane(self) -> Lane {
        Lane::splat(self)
    }
    #[inline(always)]
    fn each(self, other: Self, f: impl Fn(f64, f64) -> f64) -> Self {
        f(self, other)
    }
    fn numbers(entries: &[Self]) -> Numbers<'_> {
        Numbers::Shared(entries)
    }
}

impl Index<usize> for Lane {
    type Output = f64;
    #[inline(always)]
    fn index(&self, lane: usize) -> &f64 {
        &self.0[lane]
    }
}

impl IndexMut<usize> for Lane {
    #[inline(always)]
    fn index_mut(&mut self, lane: usize) -> &mut f64 {
        &mut self.0[lane]
    }
}

/// How many times [`crate::LANES`] runs are stepped at once where there are as many, to hide the latency of a step.
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
                for (lane, other) in self.0.iter_mut().zip(other.0) {
                    *lane = lane.$method(other);
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
    fn change<const N: usize>(numbers: &mut [Self; N], f: impl Fn([usize; 2], [f64; N]) -> [f64; N]) {
        for group in 0..G {
            let mut here = [[0.0; LANES]; N];
            for i in 0..N {
                here[i] = numbers[i].0[group].0;
            }
            for lane in 0..LANES {
                let mut now = [0.0; N];
                for i in 0..N {
                    now[i] = here[i][lane];
                }
                let changed = f([group, lane], now);
                for i in 0..N {
                    here[i][lane] = changed[i];
                }
            }
            for i in 0..N {
                numbers[i].0[group].0 = here[i];
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
        self.map(|rows| &rows[..count])
    }
    #[inline(always)]
    fn entry(&self, i: usize, [group, lane]: [usize; 2]) -> f64 {
        self[group][i].0[lane]
    }
}
