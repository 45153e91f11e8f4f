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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn oracle_errors_of_a_covariance_of_three_parameters_in_two_blocks() {
        // det [[4, 1], [1, 9]] = 35, and 16 by itself.
        let covariance = [4.0, 1.0, 0.5, 1.0, 9.0, 0.5, 0.5, 0.5, 16.0];
        let found = |norm| error_of(norm, &[1.0, 0.5, 0.25], &covariance, &[0..2, 2..3]).unwrap();
        assert!((found(Norm::Trace) - 12.5_f64.sqrt()).abs() < 1e-12);
        assert!((found(Norm::LogDet) - (35.0_f64 * 16.0).powf(1.0 / 6.0)).abs() < 1e-12);
        // One block of all three: det = 35 × 16 − (4 × .25 + 9 × .25 − 2 × .25).
        let joint = error_of(Norm::LogDet, &[1.0; 3], &covariance, std::slice::from_ref(&(0..3))).unwrap();
        assert!((joint.powi(6) - (560.0 - 2.75)).abs() < 1e-9, "{}", joint.powi(6));
        assert_eq!(
            error_of(Norm::LogDet, &[1.0; 2], &[1.0, 1.0, 1.0, 1.0], std::slice::from_ref(&(0..2))),
            None
        );
    }

    #[test]
    fn law_four_times_the_trial_halves_the_promised_error() {
        for norm in [Norm::Trace, Norm::LogDet] {
            let one = promised_error(norm, 2.5, 3, 100.0, 100.0);
            assert!((promised_error(norm, 2.5, 3, 100.0, 400.0) - 0.5 * one).abs() < 1e-12);
        }
    }
}
