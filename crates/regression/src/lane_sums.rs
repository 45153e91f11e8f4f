use std::ops::Range;

use numerics::lanes::lane_of;
use numerics::{LANES, Lane, Number, transposed};

use crate::spans::columns::{self, Kept};
use crate::sums::{AnyBatch, over_batch};
use crate::{Batch, DegreeSums, Sums};

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
        let mut degrees = batch.model().degrees.each_ref().map(DegreeSums::of);
        let count = Lane::splat(range.len() as f64);
        degrees.iter_mut().flat_map(|degree| degree.a.last_mut()).for_each(|corner| *corner = count);
        let mut sums = Self { degrees, range };
        over_batch!(batch, |batch| {
            columns::add_instruments(&batch, kept, sums.range.clone(), &mut sums.degrees);
        });
        sums
    }

    /// Adds the sums that depend on the measured states.
    pub(crate) fn with_measured(&self, batch: AnyBatch, kept: &Kept) -> Self {
        let mut sums = self.clone();
        over_batch!(batch, |batch| {
            columns::add_measured(&batch, kept, sums.range.clone(), &mut sums.degrees);
        });
        sums
    }

    /// The sums of one lane.
    pub(crate) fn lane(&self, lane: usize) -> Sums {
        let degrees = self.degrees.iter().map(|degree| degree.lane(lane)).collect();
        Sums { samples: self.range.len() as u64, degrees }
    }

    /// The sums of all lanes, which have the same samples.
    pub(crate) fn whole(self) -> [DegreeSums<Lane>; 3] {
        self.degrees
    }

    /// Writes these sums into one lane of `degrees`.
    pub(crate) fn put(&self, lane: usize, degrees: &mut [DegreeSums<Lane>; 3]) {
        degrees.iter_mut().zip(&self.degrees).for_each(|(degree, other)| degree.take(lane, other));
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
        for (lanes, other) in [
            (&mut self.a, &other.a),
            (&mut self.b, &other.b),
            (&mut self.instrument_squares, &other.instrument_squares),
            (&mut self.regressor_squares, &other.regressor_squares),
        ] {
            lanes.iter_mut().zip(other).for_each(|(entry, other)| entry[lane] = other[lane]);
        }
    }
}

/// The moments of one maneuver.
#[derive(Clone, Debug, PartialEq)]
pub struct ManeuverMoments {
    /// Number of regression pairs.
    pub samples: u64,
    /// Per degree of freedom M = mean of φ̃ ζ̃ᵀ = \[\[X̄, Ȳ\], \[Z̄ᵀ, 1\]\], p̃ × p̃, row-major.
    pub matrices: Vec<Vec<f64>>,
    /// Per degree of freedom the largest change of an entry from the first to the second half of the maneuver, relative
    /// to the root mean squares of its regressor and instrument.
    pub nonstationarity: Vec<f64>,
}

/// The moments of each lane of a batch of whole maneuvers.
pub fn moments<X: Number>(batch: &Batch<X>) -> Vec<ManeuverMoments> {
    let middle = batch.samples() / 2;
    let kept = Kept::of(batch.any());
    let sums = |range| LaneSums::of_instruments(batch.any(), &kept, range).with_measured(batch.any(), &kept);
    let halves = [sums(0..middle), sums(middle..batch.samples())];
    (0..LANES)
        .map(|lane| {
            let [first, second] = [halves[0].lane(lane), halves[1].lane(lane)];
            let mut whole = first.clone();
            whole.merge(&second);
            ManeuverMoments {
                samples: whole.samples,
                matrices: (0..whole.degrees.len()).map(|d| mean_transposed(&whole, d)).collect(),
                nonstationarity: (0..whole.degrees.len())
                    .map(|d| change(&whole, &first, &second, d))
                    .collect(),
            }
        })
        .collect()
}

/// (A/N)ᵀ: rows φ̃, columns ζ̃.
fn mean_transposed(sums: &Sums, d: usize) -> Vec<f64> {
    let degree = &sums.degrees[d];
    let n = sums.samples.max(1) as f64;
    transposed(degree.parameters() + 1, &degree.a).into_iter().map(|entry| entry / n).collect()
}

fn change(whole: &Sums, first: &Sums, second: &Sums, d: usize) -> f64 {
    let degree = &whole.degrees[d];
    let p = degree.parameters();
    let n = whole.samples.max(1) as f64;
    let size = |squares: &[f64], i: usize| if i < p { (squares[i] / n).sqrt() } else { 1.0 };
    let mean = |sums: &Sums, k: usize| sums.degrees[d].a[k] / sums.samples.max(1) as f64;
    let relative = |k: usize| {
        let scale =
            size(&degree.instrument_squares, k / (p + 1)) * size(&degree.regressor_squares, k % (p + 1));
        if scale > 0.0 { (mean(second, k) - mean(first, k)).abs() / scale } else { 0.0 }
    };
    (0..(p + 1) * (p + 1)).map(relative).fold(0.0, f64::max)
}
