//! Quantiles and spread.

use numerics::statistics::{median, quantile, sorted, spread, streamed_median};

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

#[test]
fn law_many_values_have_the_median_that_they_have_in_memory() {
    let mixed = |n: u64| (0..n).map(|i| (i.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 40) as f64 - 8e6);
    let near = |n: u64| (0..n).map(|i| 0.01 + 1e-13 * ((i * 7919) % 4001) as f64);
    let few = |n: u64| (0..n).map(|i| f64::from(i % 3 == 0) - 0.0);
    // More than are selected from in memory.
    let many = (1 << 18) + 1;
    for n in [0, 1, 2, 5, many, many + 1] {
        assert_eq!(streamed_median(|| mixed(n)), median(mixed(n).collect()), "{n} mixed");
        assert_eq!(streamed_median(|| near(n)), median(near(n).collect()), "{n} near each other");
        assert_eq!(streamed_median(|| few(n)), median(few(n).collect()), "{n} of two values");
    }
    let halves = || (0..2 * many).map(|i| if i < many { 1.0 } else { 2.0 });
    assert_eq!(streamed_median(halves), Some(1.5));
}
