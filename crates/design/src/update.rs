//! A promise against the covariance of an estimate.

use std::ops::Range;

use numerics::symmetric;

use crate::Norm;

/// The error that a norm measures of a covariance, n × n: for the trace the root of Σ weight × variance; for the determinant
/// |covariance|^(1/2n), with the correlations inside of `blocks` alone. `None` where the covariance is singular.
pub fn error_of(norm: Norm, weights: &[f64], covariance: &[f64], blocks: &[Range<usize>]) -> Option<f64> {
    let n = weights.len();
    let variance = |i: usize| covariance[i * n + i];
    match norm {
        Norm::Trace => Some(weights.iter().enumerate().map(|(i, w)| w * variance(i)).sum::<f64>().sqrt()),
        Norm::LogDet => {
            let logs = blocks.iter().map(|block| log_det(n, covariance, block.clone()));
            let sum = logs.sum::<Option<f64>>()?;
            Some(libm::exp(0.5 * sum / n as f64))
        }
    }
}

/// The same error as a design predicts it: `value` of the criterion of `parameters` for so many `samples`, at a trial of `of`.
pub fn promised_error(norm: Norm, value: f64, parameters: usize, samples: f64, of: f64) -> f64 {
    let shorter = (samples / of).sqrt();
    match norm {
        Norm::Trace => value.max(0.0).sqrt() * shorter,
        Norm::LogDet => libm::exp(0.5 * value / parameters as f64) * shorter,
    }
}

/// log det of a block, from its variances and its correlations.
fn log_det(n: usize, covariance: &[f64], block: Range<usize>) -> Option<f64> {
    let size = block.len();
    let spread = |i: usize| covariance[i * n + i].sqrt();
    let entry = |k: usize| {
        let (i, j) = (block.start + k / size, block.start + k % size);
        covariance[i * n + j] / (spread(i) * spread(j))
    };
    let correlations: Vec<f64> = (0..size * size).map(entry).collect();
    let (values, _) = symmetric(size, &correlations)?;
    let all = values.iter().all(|value| *value > 0.0);
    let logs = values.iter().map(|value| libm::log(*value)).sum::<f64>();
    all.then(|| logs + 2.0 * block.map(|i| libm::log(spread(i))).sum::<f64>())
}
