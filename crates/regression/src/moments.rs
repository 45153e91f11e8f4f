use numerics::{LANES, Number, transposed};

use crate::lane_sums::LaneSums;
use crate::spans::Kept;
use crate::{Batch, Sums};

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
