use std::ops::Range;

use numerics::Lane;
use numerics::lanes::lane_of;
use ship::model::Model;

use crate::batch::{AnyBatch, over_batch};
use crate::spans::{self, Kept};
use crate::{DegreeSums, Sums};

/// [`Sums`] of a batch over some samples, lane by lane.
#[derive(Clone)]
pub(crate) struct LaneSums {
    degrees: [DegreeSums<Lane>; 3],
    range: Range<usize>,
}

impl LaneSums {
    /// The sums that depend on the instruments alone, over samples `range`; the others are zero. `kept` is ζ of all
    /// samples, if stored.
    pub(crate) fn of_instruments(batch: AnyBatch, kept: &Kept, range: Range<usize>) -> Self {
        let mut sums = Self::zero(batch.model(), range);
        over_batch!(batch, |batch| {
            spans::add_instruments(&batch, kept, sums.range.clone(), &mut sums.degrees);
        });
        sums
    }

    /// Adds the sums that depend on the measured states.
    pub(crate) fn with_measured(&self, batch: AnyBatch, kept: &Kept) -> Self {
        let mut sums = self.clone();
        over_batch!(batch, |batch| {
            spans::add_measured(&batch, kept, sums.range.clone(), &mut sums.degrees);
        });
        sums
    }

    /// Zero sums with the number of samples.
    fn zero(model: &Model, range: Range<usize>) -> Self {
        let mut degrees = model.degrees.each_ref().map(DegreeSums::of);
        let count = Lane::splat(range.len() as f64);
        degrees.iter_mut().flat_map(|own| own.a.last_mut()).for_each(|corner| *corner = count);
        Self { degrees, range }
    }

    /// The sums of one lane.
    pub(crate) fn lane(&self, lane: usize) -> Sums {
        let degrees = self.degrees.iter().map(|own| own.lane(lane)).collect();
        Sums { samples: self.range.len() as u64, degrees }
    }

    /// The sums of all lanes, which have the same samples.
    pub(crate) fn whole(self) -> [DegreeSums<Lane>; 3] {
        self.degrees
    }

    /// Writes these sums into one lane of `degrees`.
    pub(crate) fn put(&self, lane: usize, degrees: &mut [DegreeSums<Lane>; 3]) {
        degrees.iter_mut().zip(&self.degrees).for_each(|(own, other)| own.take(lane, other));
    }
}

impl DegreeSums<Lane> {
    /// The sums of one lane.
    pub(crate) fn lane(&self, lane: usize) -> DegreeSums {
        DegreeSums {
            a: lane_of(&self.a, lane),
            b: lane_of(&self.b, lane),
            instrument_squares: lane_of(&self.instrument_squares, lane),
            regressor_squares: lane_of(&self.regressor_squares, lane),
            known: self.known.clone(),
        }
    }

    /// Copies one lane of `other`.
    fn take(&mut self, lane: usize, other: &Self) {
        for (own, other) in [
            (&mut self.a, &other.a),
            (&mut self.b, &other.b),
            (&mut self.instrument_squares, &other.instrument_squares),
            (&mut self.regressor_squares, &other.regressor_squares),
        ] {
            own.iter_mut().zip(other).for_each(|(own, other)| own[lane] = other[lane]);
        }
    }
}
