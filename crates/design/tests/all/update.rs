//! Errors of a covariance beside those that were promised.

use design::{Norm, error_of, promised_error};

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
    assert_eq!(error_of(Norm::LogDet, &[1.0; 2], &[1.0, 1.0, 1.0, 1.0], std::slice::from_ref(&(0..2))), None);
}

#[test]
fn law_four_times_the_trial_halves_the_promised_error() {
    for norm in [Norm::Trace, Norm::LogDet] {
        let one = promised_error(norm, 2.5, 3, 100.0, 100.0);
        assert!((promised_error(norm, 2.5, 3, 100.0, 400.0) - 0.5 * one).abs() < 1e-12);
    }
}
