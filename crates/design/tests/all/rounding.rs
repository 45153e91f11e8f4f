//! Shares to whole numbers.

use design::apportion;
use proptest::prelude::*;

#[test]
fn the_papers_model_ship_gets_half_and_three_sixths() {
    assert_eq!(apportion(&[0.49, 0.2, 0.13, 0.18], 6), vec![3, 1, 1, 1]);
    assert_eq!(apportion(&[0.5, 0.0, 0.25, 0.25], 4), vec![2, 0, 1, 1]);
    assert_eq!(apportion(&[0.6, 0.3, 0.1], 1), vec![1, 0, 0]);
}

proptest! {
    #[test]
    fn law_counts_sum_to_the_total_and_stay_within_one_of_the_quota(weights in prop::collection::vec(0.0f64..1.0, 1..12), total in 12u64..2000) {
        let sum: f64 = weights.iter().sum();
        prop_assume!(sum > 1e-3);
        let shares: Vec<f64> = weights.iter().map(|w| w / sum).collect();
        let counts = apportion(&shares, total);
        prop_assert_eq!(counts.iter().sum::<u64>(), total);
        for (share, count) in shares.iter().zip(&counts) {
            prop_assert!((*count as f64 - share * total as f64).abs() <= shares.len() as f64 / 2.0 + 1.0);
            prop_assert!(*share > 0.0 || *count == 0);
        }
        // Pukelsheim & Rieder's rule: one factor rounds all shares up to their counts, so none has too many beside another.
        let used = || shares.iter().zip(&counts).filter(|(share, _)| **share > 0.0);
        let above = used().map(|(share, count)| (*count as f64 - 1.0) / share).fold(0.0, f64::max);
        let below = used().map(|(share, count)| *count as f64 / share).fold(f64::INFINITY, f64::min);
        prop_assert!(above <= below * (1.0 + 1e-9), "{:?} {:?}", shares, counts);
    }
}
