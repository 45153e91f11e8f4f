//! Quantiles and spread over runs.

mod interval;
mod streamed_median;

use statrs::distribution::{ChiSquared, ContinuousCDF};
use statrs::function::erf::erfc;

use crate::Number;

pub use interval::{
    Z, clustered_share, mean_interval, paired_median, quantile_interval, quantile_ranks, wilson,
};
pub use streamed_median::median_again;

/// Mean; `None` if empty.
pub fn mean(values: &[f64]) -> Option<f64> {
    (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
}

/// Standard deviation, `None` below two values.
pub fn spread(values: &[f64]) -> Option<f64> {
    let mean = mean(values)?;
    let squares: f64 = values.iter().map(|x| (x - mean) * (x - mean)).sum();
    (values.len() > 1).then(|| (squares / (values.len() - 1) as f64).sqrt())
}

/// The quantile `q` of ascending `sorted`, interpolated; `None` if empty or among infinite values.
pub fn quantile(sorted: &[f64], q: f64) -> Option<f64> {
    let last = sorted.len().checked_sub(1)?;
    let place = q * last as f64;
    let (low, high) = (place.floor() as usize, place.ceil() as usize);
    let value = if low == high {
        sorted[low]
    } else {
        sorted[low] + (place - low as f64) * (sorted[high] - sorted[low])
    };
    value.is_finite().then_some(value)
}

/// The quantile 0.5 of `values` in any order, by selection, which is faster than sorting for many values.
pub fn median(mut values: Vec<f64>) -> Option<f64> {
    let last = values.len().checked_sub(1)?;
    let (_, low, above) = values.select_nth_unstable_by(last / 2, f64::total_cmp);
    let low = *low;
    match above.iter().copied().min_by(f64::total_cmp).filter(|_| last % 2 == 1) {
        Some(high) => quantile(&[low, high], 0.5),
        None => quantile(&[low], 0.5),
    }
}

/// Ascending, absent values last as infinity.
pub fn sorted(values: impl Iterator<Item = Option<f64>>) -> Vec<f64> {
    let mut all: Vec<f64> = values.map(|v| v.unwrap_or(f64::INFINITY)).collect();
    all.sort_by(f64::total_cmp);
    all
}

/// Fewest draws of which two enclose the median of their distribution at 95 %.
pub const LEAST_FOR_MEDIAN: u64 = 6;

/// The 95 % interval of the median of `pairs` pairs in words, such as `0.9 to 1.1`. An end is missing where
/// the pairs do not bound it.
///
/// # Errors
/// Why there is none: too few pairs, or too many of which one has no value.
pub fn median_interval_in_words(
    ends: [Option<f64>; 2],
    pairs: u64,
    number: impl Fn(f64) -> String,
) -> Result<String, String> {
    if pairs < LEAST_FOR_MEDIAN {
        return Err(format!("too few pairs for a 95 % interval: {pairs}, at least {LEAST_FOR_MEDIAN}"));
    }
    match ends.map(|end| end.filter(|end| end.is_finite()).map(&number)) {
        [Some(low), Some(high)] => Ok(format!("{low} to {high}")),
        [Some(low), None] => Ok(format!("from {low} up")),
        [None, Some(high)] => Ok(format!("up to {high}")),
        [None, None] => Err("no 95 % interval: too many pairs of which one has no value".to_owned()),
    }
}

/// Trajectories that are averaged sample by sample.
///
/// The mean moves towards each by its share of what it is off, so that the mean of equals is what they are, to the bit.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MeanTrajectory<N> {
    count: u32,
    mean: Vec<N>,
    /// Sums of squared distances from the mean.
    squares: Vec<N>,
}

impl<N: Number> MeanTrajectory<N> {
    /// Adds one, as long as the others.
    pub fn add(&mut self, states: &[N]) {
        if self.count == 0 {
            (self.mean, self.squares) = (states.to_vec(), vec![N::ZERO; states.len()]);
        }
        self.count += 1;
        let share = N::from(f64::from(self.count).recip());
        for ((mean, squares), state) in self.mean.iter_mut().zip(&mut self.squares).zip(states) {
            let off = *state - *mean;
            *mean += off * share;
            *squares += off * (*state - *mean);
        }
    }

    /// The mean.
    pub fn mean(&self) -> &[N] {
        &self.mean
    }
}

impl MeanTrajectory<f64> {
    /// Standard deviations of the trajectories about their mean, with one less than their number; 0 of a single one.
    pub fn spread(&self) -> Vec<f64> {
        let freedom = f64::from(self.count.max(2) - 1);
        self.squares.iter().map(|sum| (sum / freedom).sqrt()).collect()
    }
}

// Tail probabilities.

/// P(χ² ≥ x) for `freedom` degrees of freedom; 1 without any.
pub fn chi_square_tail(x: f64, freedom: f64) -> f64 {
    ChiSquared::new(freedom).map_or(1.0, |distribution| distribution.sf(x))
}

/// log P(χ² ≥ x) for `freedom` degrees of freedom, at least one; by the tail's expansion if the probability underflows.
pub fn log_chi_square_tail(x: f64, freedom: usize) -> f64 {
    let (p, half) = (chi_square_tail(x.max(0.0), freedom as f64), 0.5 * freedom as f64);
    match p > 1e-290 {
        true => libm::log(p),
        false => (half - 1.0) * libm::log(0.5 * x) - 0.5 * x - libm::lgamma(half),
    }
}

/// P(|Z| ≥ |z|) for a standard normal Z, to a relative 1e-10.
pub fn normal_tails(z: f64) -> f64 {
    erfc(z.abs() / std::f64::consts::SQRT_2)
}

/// Half the width of a 95 % interval by Student's t with `freedom` degrees of freedom, in standard errors: by
/// the expansion of Fisher and Cornish (*Technometrics* 2, 1960), to a relative 2e-4, from nine degrees on. Below, that of
/// the whole degrees; infinite without one.
pub fn student_half_width(freedom: f64) -> f64 {
    const Z: f64 = 1.959_963_985;
    const FEW: [f64; 9] = [
        f64::INFINITY,
        12.706_204_736,
        4.302_652_730,
        3.182_446_305,
        2.776_445_105,
        2.570_581_836,
        2.446_911_851,
        2.364_624_252,
        2.306_004_135,
    ];
    if let Some(few) = FEW.get(freedom as usize) {
        return *few;
    }
    let square = Z * Z;
    let first = (square + 1.0) / 4.0;
    let second = ((5.0 * square + 16.0) * square + 3.0) / 96.0;
    let third = (((3.0 * square + 19.0) * square + 17.0) * square - 15.0) / 384.0;
    Z * (1.0 + (first + (second + third / freedom) / freedom) / freedom)
}
