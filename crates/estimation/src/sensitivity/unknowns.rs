use numerics::{LANES, Lane, Number};
use ship::engine::Stepping;

/// The layout of unknowns in columns of lanes.
pub trait Unknowns: Number + Stepping {
    /// Unknowns per column.
    const PER_COLUMN: usize;
    /// The entry of unknown `i` in its column.
    fn of_column(column: Lane, i: usize) -> Self;
    /// Adds to the entry of unknown `i` in its column.
    fn add_to(self, column: &mut Lane, i: usize);
    /// A number of every run; of the first for a single run.
    fn by_lane(of: impl Fn(usize) -> f64) -> Self;
}

impl Unknowns for Lane {
    const PER_COLUMN: usize = 1;
    #[inline(always)]
    fn of_column(column: Lane, _: usize) -> Self {
        column
    }
    #[inline(always)]
    fn add_to(self, column: &mut Lane, _: usize) {
        *column += self;
    }
    #[inline(always)]
    fn by_lane(of: impl Fn(usize) -> f64) -> Self {
        let mut lanes = Self::ZERO;
        for (lane, own) in lanes.0.iter_mut().enumerate() {
            *own = of(lane);
        }
        lanes
    }
}

impl Unknowns for f64 {
    const PER_COLUMN: usize = LANES;
    #[inline(always)]
    fn of_column(column: Lane, i: usize) -> Self {
        column[i % LANES]
    }
    #[inline(always)]
    fn add_to(self, column: &mut Lane, i: usize) {
        column[i % LANES] += self;
    }
    #[inline(always)]
    fn by_lane(of: impl Fn(usize) -> f64) -> Self {
        of(0)
    }
}
