//! Quantiles and spread.

use numerics::statistics::{median, quantile, sorted, spread};

#[test]
fn law_spread_is_the_sample_standard_deviation() {
    assert_eq!(spread(&[1.0, 3.0]), Some(2.0_f64.sqrt()));
    assert_eq!(spread(&[1.0]), None);
}

#[test]
fn law_the_median_halves_what_is_there() {
    assert_eq!(median(vec![]), None);
    assert_eq!(median(vec![3.0]), Some(3.0));
    assert_eq!(median(vec![5.0, 1.0, 4.0, 2.0]), Some(3.0));
    assert_eq!(median(vec![5.0, 1.0, 4.0, 2.0, -9.0]), Some(2.0));
    let values = [0.3, 0.1, 0.7, 0.2];
    assert_eq!(median(values.to_vec()), quantile(&sorted(values.into_iter().map(Some)), 0.5));
}
