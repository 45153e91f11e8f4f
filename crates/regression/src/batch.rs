use std::ops::Range;

use numerics::{LANES, Lane, Number, Numbers};
use ship::model::Model;

/// [`LANES`] runs of N samples side by side. All row-major. Data shared by the runs (`X` = `f64`) is one number per
/// entry instead of a lane; the results have the same bits.
#[derive(Clone, Copy, Debug)]
pub struct Batch<'a, X = Lane> {
    /// The model structure.
    pub model: &'a Model,
    /// Measured states u, v \[m/s\], r \[rad/s\]: (N+1) × 3.
    pub measured: &'a [Lane],
    /// The states that the instruments are evaluated at: (N+1) × 3. For instrumental variables those of a nominal
    /// simulation, for least squares the measured ones.
    pub instrument_states: &'a [X],
    /// Inputs and measured disturbances: N × exogenous.
    pub exogenous: &'a [X],
    /// Those that the instruments are evaluated with: N × exogenous. For least squares the above.
    pub instrument_exogenous: &'a [X],
    /// Per run, the first sample of each segment, ascending from 0.
    pub segments: [&'a [usize]; LANES],
}

/// A batch with its number type erased, so that passes are compiled here and not in every crate and test that calls
/// them.
#[derive(Clone, Copy, Debug)]
pub(crate) enum AnyBatch<'a> {
    Lanes(Batch<'a, Lane>),
    Shared(Batch<'a, f64>),
}

/// The result of a pass over a batch of either kind, [`numerics::vectorized!`].
macro_rules! over_batch {
    ($any:expr, |$batch:ident| $pass:expr) => {
        match $any {
            $crate::batch::AnyBatch::Lanes($batch) => numerics::vectorized!($pass),
            $crate::batch::AnyBatch::Shared($batch) => numerics::vectorized!($pass),
        }
    };
}
pub(crate) use over_batch;

impl<'a> AnyBatch<'a> {
    /// The model structure.
    pub(crate) fn model(&self) -> &'a Model {
        match self {
            Self::Lanes(batch) => batch.model,
            Self::Shared(batch) => batch.model,
        }
    }
}

impl<'a, X: Number> Batch<'a, X> {
    /// This batch with its number type erased.
    pub(crate) fn any(&self) -> AnyBatch<'a> {
        let numbers =
            [self.instrument_states, self.exogenous, self.instrument_exogenous].map(|own| X::numbers(own));
        match numbers {
            [Numbers::Lanes(states), Numbers::Lanes(own), Numbers::Lanes(instruments)] => {
                AnyBatch::Lanes(self.of([states, own, instruments]))
            }
            [Numbers::Shared(states), Numbers::Shared(own), Numbers::Shared(instruments)] => {
                AnyBatch::Shared(self.of([states, own, instruments]))
            }
            _ => unreachable!("all are made of X"),
        }
    }

    /// This batch with its data as numbers of another type.
    fn of<Y>(&self, [instrument_states, exogenous, instrument_exogenous]: [&'a [Y]; 3]) -> Batch<'a, Y> {
        let Self { model, measured, segments, .. } = *self;
        Batch { model, measured, instrument_states, exogenous, instrument_exogenous, segments }
    }
}

impl<X> Batch<'_, X> {
    /// Number of regression pairs N.
    pub fn samples(&self) -> usize {
        self.measured.len() / 3 - 1
    }
}

/// Splits `range` into blocks of `N` samples: (first, count).
pub(crate) fn parts<const N: usize>(range: Range<usize>) -> impl Iterator<Item = (usize, usize)> {
    let end = range.end;
    range.step_by(N).map(move |k| (k, N.min(end - k)))
}
