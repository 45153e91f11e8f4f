//! Estimates of many runs compared with the truth.

use estimation::{RepeatedEstimates, relative_norms};

#[test]
fn law_errors_are_relative_to_the_modulus_of_the_truth() {
    let found = RepeatedEstimates::new(&[-1.0, -3.0], &[1.0, 2.0, 3.0], Some(-4.0));
    assert_eq!((found.relative_bias, found.relative_spread), (Some(0.5), Some(2f64.sqrt() / 4.0)));
    assert_eq!((found.predicted_se, found.se_ratio()), (Some(2.0), Some(2.0 / 2f64.sqrt())));
    assert!(!found.se_trusted() && RepeatedEstimates::new(&[1.0, 3.0], &[1.5], None).se_trusted());
}

#[test]
fn norms_take_the_parameters_with_a_known_truth() {
    let of = |truth| RepeatedEstimates::new(&[1.0, 3.0], &[1.0], truth);
    assert_eq!(relative_norms(&[of(None), of(Some(0.0))]), None);
    let norms = relative_norms(&[of(None), of(Some(-1.0)), of(Some(0.5))]).unwrap();
    assert_eq!(norms[..2], [18f64.sqrt(), 10f64.sqrt()]);
    assert!((norms[2] - 28f64.sqrt()).abs() < 1e-14);
}
