//! How simulated and predicted states change with what is unknown: the one engine behind estimates, their standard errors, the
//! information of experiments and its gradient.
//!
//! States go from sample to sample by [`Dynamics`]; forward sensitivities go along ([`sweep`]), adjoints go back ([`backward`]).
//! Both are columns of lanes. Numbers `X` are [`Lane`]s for runs side by side, each unknown in a column of its own; or `f64`
//! for a single run, [`LANES`] unknowns beside each other in a column ([`Unknowns`]).

mod adjoint;
mod dynamics;
mod information;
mod kalman;
mod levels;
mod products;
mod recordings;
mod sweep;

pub(crate) use adjoint::{add_draws, add_start, backward};
pub(crate) use dynamics::Dynamics;
pub use information::{OutputInformation, output_information, prediction_weights};
pub(crate) use information::{Told, channels};
pub(crate) use kalman::{Gain, filter};
pub use levels::{Flow, Gusts, Levels};
pub(crate) use products::Products;
pub use recordings::Recordings;
pub(crate) use recordings::groups;
pub use sweep::Sensitivities;
pub(crate) use sweep::{Step, sweep};

use vessel::{LANES, Lane, Number};

/// How unknowns stand in columns of lanes.
pub trait Unknowns: Number {
    /// How many stand in one column.
    const PER_COLUMN: usize;
    /// The entry of unknown `i` in its column.
    fn of_column(column: Lane, i: usize) -> Self;
    /// Adds to the entry of unknown `i` in its column.
    fn add_to(self, column: &mut Lane, i: usize);
    /// A number of every run; of the first, where there is one run.
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
        Self(std::array::from_fn(of))
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
