//! Quantiles and spread over runs.

mod again;
mod interval;
mod mean_trajectory;
mod words;

pub use again::median_again;
pub use interval::{
    Z, clustered_share, mean_interval, paired_median, quantile_interval, quantile_ranks, wilson,
};
pub use mean_trajectory::MeanTrajectory;
pub use words::{LEAST_FOR_MEDIAN, median_interval_in_words};

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
